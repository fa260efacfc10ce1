//! Measured and exact references, one file a paper.

pub mod archimedes;
pub mod couette;
pub mod dam_break;
pub mod ellipsoid;
pub mod hulme_1982;
pub mod hydrostatics;
pub mod integrators;
pub mod kirchhoff_1876;
pub mod krog_2010;
pub mod lobovsky_2014;
pub mod martin_moyce_1952;
pub mod pirovano_2011;
pub mod pirovano_2011_integrators;
pub mod poiseuille;
pub mod potential_flow;
pub mod published_time;
pub mod standing_wave;
pub mod taylor_green;

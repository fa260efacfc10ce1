//! Levels: what stands in their files, read and checked.
//!
//! A level is a section through a channel [`DEPTH`] wide: x to the right, y up, from the lower left corner, in metres.

use std::path::Path;

use bevy::math::Vec2;
use freshet_core::error::{InvalidInput, check_range};
use serde::Deserialize;

/// Width of the channel, m.
pub const DEPTH: f32 = 0.4;
/// The least edge of anything, m.
const LEAST: f32 = 0.04;

/// One level.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Level {
    /// Its name; not empty.
    pub name: String,
    /// What is told before it begins.
    pub hint: String,
    /// Width and height, m, 1 to 10.
    pub size: Vec2,
    /// What is built of stone.
    pub walls: Vec<Wall>,
    /// Water at the start.
    pub water: Vec<Area>,
    /// Water that flows in.
    #[serde(default)]
    pub springs: Vec<Spring>,
    /// Gates, closed at the start, which slide up.
    pub gates: Vec<Area>,
    /// Gratings: crates lie on them, water falls through.
    #[serde(default)]
    pub gratings: Vec<Area>,
    /// The mill wheel.
    pub wheel: Wheel,
    /// Where water counts.
    pub basin: Area,
    /// What may be placed.
    pub crates: Crates,
    /// What has to be reached.
    pub goal: Goal,
    /// Moves that win, in the order of time.
    pub moves: Vec<Move>,
}

/// A rectangle.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Area {
    /// Lower left corner, m.
    pub low: Vec2,
    /// Upper right corner, m.
    pub high: Vec2,
}

/// Stone.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Wall {
    /// A rectangle.
    Block {
        /// Lower left corner, m.
        low: Vec2,
        /// Upper right corner, m.
        high: Vec2,
    },
    /// A slab whose upper face goes from the left to the right.
    Ramp {
        /// Left end of the upper face, m.
        from: Vec2,
        /// Right end of it, m.
        to: Vec2,
        /// m, 0.1 to 1.
        thickness: f32,
    },
}

/// A pipe that water comes out of, to the right.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spring {
    /// Its mouth, m.
    pub at: Vec2,
    /// m, 0.03 to 0.15.
    pub radius: f32,
    /// m/s, 0.2 to 5.
    pub speed: f32,
}

/// A wheel on an axle.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wheel {
    /// Its axle, m.
    pub center: Vec2,
    /// m, 0.3 to 1.
    pub radius: f32,
    /// Number of blades, 4 to 12.
    pub blades: u32,
    /// Torque of the mill at one radian a second, N m, 0 to 100.
    pub drag: f32,
}

/// What may be placed.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crates {
    /// How many, 0 to 20.
    pub count: u32,
    /// Edge, m, 0.2 to 0.39: they fit into the channel.
    pub size: f32,
    /// kg/m3, 100 to 5000.
    pub density: f32,
}

/// What has to be reached.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Goal {
    /// Water in the basin, 1 to 5000 l.
    pub litres: f32,
    /// Turns of the wheel, 0 to 1000.
    pub turns: f32,
    /// Time for it, s, 1 to 600.
    pub seconds: f32,
}

/// A move of autoplay.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Move {
    /// When, s from the start, 0 to 600.
    pub at: f32,
    /// What.
    pub what: Action,
}

/// What a player can do.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
pub enum Action {
    /// Opens a gate, or closes it; 0 is the first.
    Gate(usize),
    /// Places a crate; its centre, m.
    Crate(Vec2),
}

impl Area {
    /// Its centre, m.
    pub fn center(&self) -> Vec2 {
        (self.low + self.high) / 2.0
    }

    /// Its edges, m.
    pub fn size(&self) -> Vec2 {
        self.high - self.low
    }

    /// Whether a point lies in it.
    pub fn contains(&self, point: Vec2) -> bool {
        point.cmpge(self.low).all() && point.cmple(self.high).all()
    }

    fn check(&self, name: &str, level: Vec2) -> Result<(), InvalidInput> {
        check_point(&format!("{name}.low"), self.low, level)?;
        check_point(&format!("{name}.high"), self.high, level)?;
        for (axis, low, high) in [("x", self.low.x, self.high.x), ("y", self.low.y, self.high.y)] {
            if high < low + LEAST {
                let (field, allowed) = (format!("{name}.high.{axis}"), format!("at least {:.2} m", low + LEAST));
                return Err(InvalidInput::new(field, high, allowed));
            }
        }
        Ok(())
    }
}

impl Spring {
    /// How much flows, m3/s.
    pub fn flow(&self) -> f32 {
        std::f32::consts::PI * self.radius.powi(2) * self.speed
    }
}

impl Level {
    /// All levels of a folder, in the order of their names. The error is one line with file, field, value and range.
    pub fn read_all(folder: &Path) -> Result<Vec<Self>, String> {
        let name = folder.display();
        let entries = std::fs::read_dir(folder).map_err(|error| format!("{name}: {error}"))?;
        let mut paths: Vec<_> = entries.flatten().map(|entry| entry.path()).collect();
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "ron"));
        paths.sort();
        if paths.is_empty() {
            return Err(format!("{name}: no level; allowed: at least one *.ron"));
        }
        paths.iter().map(|path| Self::read(path)).collect()
    }

    fn read(path: &Path) -> Result<Self, String> {
        let name = path.display();
        let text = std::fs::read_to_string(path).map_err(|error| format!("{name}: {error}"))?;
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let level: Self = options.from_str(&text).map_err(|error| format!("{name}: {error}"))?;
        level.check().map_err(|error| format!("{name}: {error}"))?;
        Ok(level)
    }

    fn check(&self) -> Result<(), InvalidInput> {
        if self.name.is_empty() {
            return Err(InvalidInput::new("name", "\"\"", "a text that is not empty"));
        }
        check_range("size.x", self.size.x, 1.0, 10.0, "m")?;
        check_range("size.y", self.size.y, 1.0, 10.0, "m")?;
        for (index, wall) in self.walls.iter().enumerate() {
            wall.check(&format!("walls[{index}]"), self.size)?;
        }
        for (name, areas) in [("water", &self.water), ("gates", &self.gates), ("gratings", &self.gratings)] {
            for (index, area) in areas.iter().enumerate() {
                area.check(&format!("{name}[{index}]"), self.size)?;
            }
        }
        if self.water.is_empty() && self.springs.is_empty() {
            return Err(InvalidInput::new("water", "[]", "at least one, or a spring"));
        }
        for (index, spring) in self.springs.iter().enumerate() {
            let name = format!("springs[{index}]");
            check_point(&format!("{name}.at"), spring.at, self.size)?;
            check_range(&format!("{name}.radius"), spring.radius, 0.03, 0.15, "m")?;
            check_range(&format!("{name}.speed"), spring.speed, 0.2, 5.0, "m/s")?;
        }
        check_point("wheel.center", self.wheel.center, self.size)?;
        check_range("wheel.radius", self.wheel.radius, 0.3, 1.0, "m")?;
        if !(4..=12).contains(&self.wheel.blades) {
            return Err(InvalidInput::new("wheel.blades", self.wheel.blades, "4 to 12"));
        }
        check_range("wheel.drag", self.wheel.drag, 0.0, 100.0, "N m s")?;
        self.basin.check("basin", self.size)?;
        if self.crates.count > 20 {
            return Err(InvalidInput::new("crates.count", self.crates.count, "0 to 20"));
        }
        check_range("crates.size", self.crates.size, 0.2, DEPTH - 0.01, "m")?;
        check_range("crates.density", self.crates.density, 100.0, 5000.0, "kg/m3")?;
        check_range("goal.litres", self.goal.litres, 1.0, 5000.0, "l")?;
        check_range("goal.turns", self.goal.turns, 0.0, 1000.0, "turns")?;
        check_range("goal.seconds", self.goal.seconds, 1.0, 600.0, "s")?;
        for (index, made) in self.moves.iter().enumerate() {
            let name = format!("moves[{index}]");
            check_range(&format!("{name}.at"), made.at, 0.0, 600.0, "s")?;
            match made.what {
                Action::Gate(gate) if gate >= self.gates.len() => {
                    let allowed = format!("the number of a gate, less than {}", self.gates.len());
                    return Err(InvalidInput::new(format!("{name}.what"), gate, allowed));
                }
                Action::Gate(_) => {}
                Action::Crate(place) => check_point(&format!("{name}.what"), place, self.size)?,
            }
        }
        Ok(())
    }

    /// Volume of the water that there will have been, m3.
    pub fn volume(&self) -> f32 {
        let standing: f32 = self.water.iter().map(|area| area.size().element_product() * DEPTH).sum();
        standing + self.goal.seconds * self.flow()
    }

    /// What springs bring, m3/s.
    pub fn flow(&self) -> f32 {
        self.springs.iter().map(Spring::flow).sum()
    }
}

impl Wall {
    fn check(&self, name: &str, level: Vec2) -> Result<(), InvalidInput> {
        match *self {
            Self::Block { low, high } => Area { low, high }.check(name, level),
            Self::Ramp { from, to, thickness } => {
                check_point(&format!("{name}.from"), from, level)?;
                check_point(&format!("{name}.to"), to, level)?;
                if to.x < from.x + LEAST {
                    return Err(InvalidInput::new(
                        format!("{name}.to.x"),
                        to.x,
                        format!("at least {:.2} m", from.x + LEAST),
                    ));
                }
                check_range(&format!("{name}.thickness"), thickness, 0.1, 1.0, "m")
            }
        }
    }
}

/// Walls may stand a little beyond the level.
fn check_point(name: &str, point: Vec2, level: Vec2) -> Result<(), InvalidInput> {
    check_range(&format!("{name}.x"), point.x, -0.5, level.x + 0.5, "m")?;
    check_range(&format!("{name}.y"), point.y, -0.5, level.y + 0.5, "m")
}

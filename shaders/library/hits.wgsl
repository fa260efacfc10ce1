// Which candidates of a particle are its neighbours: a bit each, written by the density pass, so that the acceleration
// pass loads only those, a sixth of them. A word for each of the nine rows.
#define_import_path freshet::hits

// Places of a row that have a bit. A row of three cells holds 24 particles at rest with H = 2d.
const PLACES: u32 = 30u;
const PLACE_MASK: u32 = 0x3fffffffu;
// The row has samples of walls or bodies.
const SAMPLES: u32 = 0x40000000u;
// The row has more places.
const MORE: u32 = 0x80000000u;

// The particle's own row, whose word is elsewhere: the memory of the state has eight words.
const OWN_ROW: u32 = 4u;

fn word_of(row: u32) -> u32 {
    return select(row, row - 1u, row > OWN_ROW);
}

fn bit(t: u32, is_hit: bool) -> u32 {
    return select(0u, 1u << (t & 31u), is_hit && t < PLACES);
}

// Which candidates of a particle are its neighbours: a bit each, written by the density pass, so that the acceleration
// pass loads only those, a quarter of them. A word for each of the nine rows.
#define_import_path freshet::hits

// The number of the first cell of the row that is within reach.
const BEGIN: u32 = 3u;
// The row has samples of walls or bodies.
const SAMPLES: u32 = 4u;
// The row has more places than there are bits for.
const MORE: u32 = 8u;
// The bits of places, from the first cell within reach on, are the others. A row holds up to 20 particles at rest with
// H = 2d.
const FIRST_PLACE: u32 = 16u;
const PLACES: u32 = 28u;

// The particle's own row, whose word is elsewhere: the memory of the state has eight words.
const OWN_ROW: u32 = 4u;

fn word_of(row: u32) -> u32 {
    return select(row, row - 1u, row > OWN_ROW);
}

// Whether nothing in the row of a word exerts a force.
fn is_empty(word: u32) -> bool {
    return (word & ~BEGIN) == 0u;
}

fn places_of(word: u32) -> u32 {
    return word & ~(FIRST_PLACE - 1u);
}

// The first place of those that are left.
fn first_of(places: u32) -> u32 {
    return firstTrailingBit(places) - 4u;
}

//! Scenes as text, in RON; every error names its line.
//!
//! The text is the scene as Rust would write it: structs in round brackets with the names of their fields, lists in square
//! ones, vectors as `(x, y, z)`. Fields with a default may be left out. Optional values may be written with or without
//! `Some` (RON's `implicit_some`); nothing else of RON is changed, so that `Spacing(0.05)` and `Box(half_extents: ...)` look
//! as they do in Rust.
//!
//! ```
//! use freshet_core::prelude::*;
//! let scene = FluidScene::from_ron(
//!     "(
//!         resolution: Spacing(0.05),
//!         volumes: [(shape: Box(half_extents: (0.5, 0.5, 0.5)), center: (0.5, 0.5, 0.5))],
//!         settings: (sound_speed: 60), // a comment
//!     )",
//! )?;
//! assert_eq!(FluidScene::from_ron(&scene.to_ron()?)?, scene);
//! let mistake = FluidScene::from_ron("(\n  resolution: Spacing(-1),\n)").unwrap_err();
//! assert_eq!(mistake.to_string(), "line 2: resolution: -1 is not allowed; allowed: 0.0001 to 100 m");
//! # Ok::<(), SceneError>(())
//! ```

use ron::error::SpannedError;
use ron::extensions::Extensions;
use ron::ser::PrettyConfig;

use crate::error::InvalidInput;
use crate::plan::{Plan, SceneError};
use crate::scene::FluidScene;

/// Most bytes of a scene file, 16 MiB; longer ones are refused unread.
pub const MAX_SCENE_BYTES: usize = 16 << 20;

/// How deep brackets may nest. A scene has eight levels; what goes deeper is refused before it can exhaust the stack.
const MAX_NESTING: usize = 32;

impl FluidScene {
    /// Reads a scene and checks every number on its own ([`validate`](Self::validate)).
    ///
    /// # Errors
    /// [`SceneError::TooLarge`], [`SceneError::Parse`] for text that is not a scene, [`SceneError::InFile`] for a value out of
    /// its range.
    pub fn from_ron(text: &str) -> Result<Self, SceneError> {
        check_size(text.len())?;
        // Some editors of Windows begin every file with a byte order mark.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let options =
            ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME).with_recursion_limit(MAX_NESTING);
        let scene: Self = options.from_str(text).map_err(|error| parse_error(text, &error))?;
        scene.validate().map_err(|error| in_file(text, error.into()))?;
        Ok(scene)
    }

    /// Reads a scene from a file's bytes, as [`from_ron`](Self::from_ron).
    ///
    /// # Errors
    /// As [`from_ron`](Self::from_ron); [`SceneError::Parse`] also for bytes that are not UTF-8.
    pub fn from_ron_bytes(bytes: &[u8]) -> Result<Self, SceneError> {
        check_size(bytes.len())?;
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let (line, column) = place(&bytes[..error.valid_up_to()]);
            let message = format!("byte 0x{:02x} is not allowed; allowed: UTF-8", bytes[error.valid_up_to()]);
            SceneError::Parse { line, column, message }
        })?;
        Self::from_ron(text)
    }

    /// The scene as text that [`from_ron`](Self::from_ron) reads, every field included.
    ///
    /// # Errors
    /// If a value is out of its range or the text would be longer than [`MAX_SCENE_BYTES`]: it could not be read again.
    pub fn to_ron(&self) -> Result<String, SceneError> {
        self.validate()?;
        let config = PrettyConfig::new().indentor("  ").new_line("\n").compact_arrays(false);
        let text = ron::Options::default()
            .to_string_pretty(self, config)
            .map_err(|error| InvalidInput::new("scene", error, "what RON can write"))?;
        check_size(text.len())?;
        Ok(text + "\n")
    }
}

/// Reads a scene and plans it; errors of the plan name their line too.
///
/// # Errors
/// As [`FluidScene::from_ron`]; those of [`Plan::new`] come as [`SceneError::InFile`].
pub fn plan_from_ron(text: &str) -> Result<(FluidScene, Plan), SceneError> {
    let scene = FluidScene::from_ron(text)?;
    match Plan::new(&scene) {
        Ok(plan) => Ok((scene, plan)),
        Err(error) => Err(in_file(text, error)),
    }
}

fn check_size(bytes: usize) -> Result<(), SceneError> {
    if bytes > MAX_SCENE_BYTES {
        return Err(SceneError::TooLarge { bytes: bytes as u64, allowed: MAX_SCENE_BYTES as u64 });
    }
    Ok(())
}

/// Line and column, from one, of the place after `before`.
fn place(before: &[u8]) -> (usize, usize) {
    let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
    let row = before.rsplit(|&byte| byte == b'\n').next().unwrap_or_default();
    (line, 1 + String::from_utf8_lossy(row).chars().count())
}

fn in_file(text: &str, error: SceneError) -> SceneError {
    let path = match &error {
        SceneError::Invalid(invalid) => invalid.field.clone(),
        SceneError::Overlap { second, .. } => format!("volumes[{second}]"),
        SceneError::Compressible { field, .. } => (*field).to_owned(),
        SceneError::Parse { .. } | SceneError::InFile { .. } | SceneError::TooLarge { .. } => return error,
    };
    SceneError::InFile { line: line_of(text, &path), error: Box::new(error) }
}

/// RON's error with the path of the field and the text it stumbled over.
fn parse_error(text: &str, error: &SpannedError) -> SceneError {
    let start = error.span.start;
    let line_start: usize = text.split_inclusive('\n').take(start.line - 1).map(str::len).sum();
    let rest = &text[line_start..];
    let offset = line_start + rest.char_indices().nth(start.col - 1).map_or(rest.len(), |(index, _)| index);
    let mut message = String::new();
    let (path, found) = path_at(text, offset);
    if !path.is_empty() {
        message = format!("{path}: ");
    }
    message += &match &error.code {
        ron::Error::IntegerOutOfBounds => format!("allowed: whole numbers from 0 to {}", u32::MAX),
        ron::Error::SuggestRawIdentifier(_) => "Expected a name".to_owned(),
        code => shortened(&code.to_string(), 400),
    };
    match found {
        Some(token) => message += &format!(", found `{}`", shortened(token, 40)),
        None => message += ", found the end of the file",
    }
    SceneError::Parse { line: start.line, column: start.col, message }
}

fn shortened(text: &str, characters: usize) -> String {
    match text.char_indices().nth(characters) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

/// The line, from one, on which a field such as `volumes[1].shape.radius` is set; where it is left out, the line of what
/// encloses it.
fn line_of(text: &str, path: &str) -> usize {
    let wanted = parse_path(path);
    let (mut depth, mut found) = (None, 0);
    walk(text, |path, at| {
        if wanted.starts_with(path) && depth.is_none_or(|depth| path.len() > depth) {
            (depth, found) = (Some(path.len()), at);
        }
        true
    });
    place(&text.as_bytes()[..found]).0
}

/// The path of the field in which `offset` lies, and the word there or next to it.
fn path_at(text: &str, offset: usize) -> (String, Option<&str>) {
    let (mut innermost, mut last) = (String::new(), 0);
    walk(text, |path, at| {
        if at > offset {
            return false;
        }
        last = at;
        innermost.clear();
        for segment in path {
            match segment {
                Segment::Field(name) if innermost.is_empty() => innermost += name,
                Segment::Field(name) => innermost += &format!(".{name}"),
                Segment::Index(index) => innermost += &format!("[{index}]"),
            }
        }
        true
    });
    let mut found = next_token(text, &mut last);
    if let Some(token) = found
        && last + token.len() <= offset
    {
        last += token.len();
        found = next_token(text, &mut last);
    }
    (innermost, found)
}

/// One step of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Segment<'a> {
    Field(&'a str),
    Index(usize),
}

fn parse_path(path: &str) -> Vec<Segment<'_>> {
    path.split(['.', '['])
        .filter_map(|part| match part.strip_suffix(']') {
            Some(index) => index.parse().ok().map(Segment::Index),
            None => Some(Segment::Field(part)),
        })
        .collect()
}

/// One open bracket.
struct Level<'a> {
    /// Where in it we are; none in the bracket of `Some(...)` or `Spacing(...)`, which is no step of a path.
    segment: Option<Segment<'a>>,
    /// Items passed.
    index: usize,
    /// Whether the next token begins an item.
    fresh: bool,
    /// Whether items without a name are steps of a path: in lists and tuples.
    counts: bool,
}

/// Tells `visit` the path and place of every item of RON text, and where its enclosing item goes on, until that says no.
///
/// It does not judge: that is the parser's task. Any text is walked in linear time, without recursion.
fn walk<'a>(text: &'a str, mut visit: impl FnMut(&[Segment<'a>], usize) -> bool) {
    let mut levels: Vec<Level<'a>> = Vec::new();
    let mut path = Vec::new();
    let mut named = false;
    let mut at = 0;
    while let Some(token) = next_token(text, &mut at) {
        let start = at;
        at += token.len();
        let first = token.as_bytes()[0];
        match first {
            b',' => {
                if let Some(level) = levels.last_mut() {
                    (level.fresh, level.segment) = (true, None);
                    level.index += 1;
                }
            }
            b')' | b']' | b'}' => {
                levels.pop();
            }
            _ => {
                let is_word = is_word(first);
                let mut after = at;
                let is_key = is_word && next_token(text, &mut after) == Some(":");
                match levels.last_mut() {
                    Some(level) if is_key => level.segment = Some(Segment::Field(token.trim_start_matches("r#"))),
                    Some(level) if level.fresh && level.counts => level.segment = Some(Segment::Index(level.index)),
                    _ => {}
                }
                if let Some(level) = levels.last_mut() {
                    level.fresh = false;
                }
                if matches!(first, b'(' | b'[' | b'{') {
                    let counts = !levels.is_empty() && !named;
                    levels.push(Level { segment: None, index: 0, fresh: true, counts });
                }
                named = is_word && !is_key;
            }
        }
        path.clear();
        path.extend(levels.iter().filter_map(|level| level.segment));
        if levels.len() > MAX_NESTING || !visit(&path, start) {
            return;
        }
    }
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'+' | b'-' | b'.') || !byte.is_ascii()
}

/// The next token from `at` on, which is moved to its start: a word or number, a string, or one character.
fn next_token<'a>(text: &'a str, at: &mut usize) -> Option<&'a str> {
    loop {
        let rest = &text[*at..];
        let skipped = match rest.as_bytes() {
            [] => return None,
            [byte, ..] if byte.is_ascii_whitespace() => 1,
            [b'/', b'/', ..] => rest.find('\n').unwrap_or(rest.len()),
            [b'/', b'*', ..] => comment_length(rest.as_bytes()),
            [b'#', b'!', ..] => rest.find(']').map_or(rest.len(), |end| end + 1),
            [b'"', ..] => return Some(&rest[..string_length(rest)]),
            [b'r', b'"' | b'#', ..] => {
                let hashes = rest[1..].len() - rest[1..].trim_start_matches('#').len();
                if rest[1 + hashes..].starts_with('"') {
                    let end = format!("\"{}", &rest[1..=hashes]);
                    let body = &rest[hashes + 2..];
                    let length = body.find(&end).map_or(body.len(), |length| length + end.len());
                    return Some(&rest[..hashes + 2 + length]);
                }
                return Some(&rest[..1 + hashes + word_length(&rest[1 + hashes..])]);
            }
            [byte, ..] if is_word(*byte) => return Some(&rest[..word_length(rest)]),
            // A character is no word, whatever bytes it has.
            _ => return Some(&rest[..1]),
        };
        *at += skipped;
    }
}

fn word_length(text: &str) -> usize {
    text.bytes().position(|byte| !is_word(byte)).unwrap_or(text.len())
}

fn string_length(text: &str) -> usize {
    let mut escaped = false;
    for (index, byte) in text.bytes().enumerate().skip(1) {
        match byte {
            _ if escaped => escaped = false,
            b'\\' => escaped = true,
            b'"' => return index + 1,
            _ => {}
        }
    }
    text.len()
}

/// Length of a comment, which may hold others.
fn comment_length(bytes: &[u8]) -> usize {
    let (mut depth, mut index) = (0, 0);
    while index < bytes.len() {
        match &bytes[index..] {
            [b'/', b'*', ..] => (depth, index) = (depth + 1, index + 2),
            [b'*', b'/', ..] => (depth, index) = (depth - 1, index + 2),
            _ => index += 1,
        }
        if depth == 0 {
            break;
        }
    }
    index
}

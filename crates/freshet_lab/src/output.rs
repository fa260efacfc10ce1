//! Where results go: a folder of CSV and SVG files, each replaced as a whole, so that an interrupted command leaves the
//! results of what it had finished and never half a file.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::error::LabError;

/// The folder of a command's results.
#[derive(Clone, Debug)]
pub struct Output {
    folder: PathBuf,
}

impl Output {
    /// Makes the folder if it is not there.
    pub fn new(folder: &Path) -> Result<Self, LabError> {
        fs::create_dir_all(folder).map_err(LabError::file(folder))?;
        Ok(Self { folder: folder.to_path_buf() })
    }

    /// Path of a file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Replaces a file's content at once.
    pub fn write(&self, name: &str, content: &str) -> Result<PathBuf, LabError> {
        let (path, partial) = (self.path(name), self.path(&format!(".{name}.part")));
        fs::write(&partial, content).map_err(LabError::file(&partial))?;
        fs::rename(&partial, &path).map_err(LabError::file(&path))?;
        Ok(path)
    }
}

/// Prints a line; that a reader went away (`| head`) is no failure of the measurement.
pub fn say(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Says which files were written.
pub fn say_files(output: &Output, names: &[&str]) {
    let paths: Vec<String> = names.iter().map(|name| output.path(name).display().to_string()).collect();
    say(format_args!("written: {}", paths.join(", ")));
}

/// Comma-separated values with comment lines (`#`) on top.
#[derive(Clone, Debug, Default)]
pub struct Csv {
    text: String,
}

impl Csv {
    /// Comment lines, then the column names.
    pub fn new<'a>(comments: impl IntoIterator<Item = &'a str>, columns: &[&str]) -> Self {
        let mut text = String::new();
        for line in comments.into_iter().flat_map(str::lines) {
            text.push_str(&format!("# {line}\n"));
        }
        let mut csv = Self { text };
        csv.row(columns.iter().copied());
        csv
    }

    /// Adds a row.
    pub fn row<T: AsRef<str>>(&mut self, cells: impl IntoIterator<Item = T>) {
        let cells: Vec<String> = cells.into_iter().map(|cell| quoted(cell.as_ref())).collect();
        self.text.push_str(&cells.join(","));
        self.text.push('\n');
    }

    /// The file's content.
    pub fn text(&self) -> &str {
        &self.text
    }
}

fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_with_commas_and_quotes_survive() {
        let mut csv = Csv::new(["one line\nand another"], &["case", "value"]);
        csv.row(["a, \"b\"", "1"]);
        assert_eq!(csv.text(), "# one line\n# and another\ncase,value\n\"a, \"\"b\"\"\",1\n");
    }

    #[test]
    fn a_file_is_replaced_and_no_part_is_left() -> Result<(), LabError> {
        let folder = std::env::temp_dir().join(format!("freshet_lab_output_{}", std::process::id()));
        let output = Output::new(&folder)?;
        output.write("a.csv", "first")?;
        let path = output.write("a.csv", "second")?;
        assert_eq!(fs::read_to_string(&path).map_err(LabError::file(&path))?, "second");
        assert_eq!(fs::read_dir(&folder).map_err(LabError::file(&folder))?.count(), 1);
        fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
    }
}

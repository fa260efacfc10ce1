//! `report`: the charts, tables and pictures of the last runs on one page, for people who would rather look than read.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use clap::Args;

use super::validate::CASES;
use crate::error::LabError;
use crate::output::{Output, say_files};
use crate::verdict::{Bound, Verdict};

/// One self-contained HTML page of everything that the other commands left in the folder.
///
/// Reads the CSV, SVG and PNG files of `--out` and of the other folders given; writes report.html into `--out`. Nothing on the
/// page comes from elsewhere: it can be sent as it is.
#[derive(Args, Clone, Debug)]
pub struct ReportArgs {
    /// Folder with the files of the other commands, and for report.html.
    #[arg(long, value_name = "DIR", default_value = "out/lab")]
    pub out: PathBuf,
    /// More folders to take pictures and charts from.
    #[arg(long, value_name = "DIR")]
    pub also: Vec<PathBuf>,
}

/// The file of the command.
const FILE: &str = "report.html";

/// Name of a command's or a case's files, head line, and what is to be seen.
struct Section {
    stem: &'static str,
    head: &'static str,
    about: &'static str,
}

/// In the order of the page; the cases of `validate` come after these.
const SECTIONS: [Section; 12] = [
    Section {
        stem: "pareto",
        head: "Speed against accuracy",
        about: "Every configuration on five scenes: what it costs, how far it is off, what nothing beats, what fails.",
    },
    Section {
        stem: "dam_break",
        head: "Dam break",
        about: "Front and height of the water against the experiments of Martin & Moyce 1952 and Lobovsky et al. 2014.",
    },
    Section {
        stem: "dam_break_dfsph",
        head: "Dam break, incompressible",
        about: "The same by divergence-free SPH, with a tenth of the substeps.",
    },
    Section {
        stem: "dam_break_water",
        head: "Dam break, water alone",
        about: "The same without any viscosity but water's, the settings of a column at rest, and against potential flow.",
    },
    Section {
        stem: "column",
        head: "Column at rest",
        about: "Pressure on the floor, weight on the container, level and speed of water that should do nothing.",
    },
    Section {
        stem: "convergence",
        head: "Pressure solves",
        about: "What the incompressible solver leaves against iterations and time, beside relaxed Jacobi steps.",
    },
    Section { stem: "float", head: "Floating ball", about: "A ball of half the density of water against Archimedes." },
    Section {
        stem: "leaks",
        head: "Leaks",
        about: "What gets through thin walls, moving walls and every shape under fire at up to 10 m/s.",
    },
    Section { stem: "leaks_dfsph", head: "Leaks, incompressible", about: "The same by divergence-free SPH." },
    Section { stem: "peers", head: "Peers", about: "The same tank run by Freshet and by others, in turn in one run." },
    Section {
        stem: "bench",
        head: "Speed",
        about: "Nanoseconds per particle and step, by pass and number of threads.",
    },
    Section {
        stem: "stability",
        head: "Stability",
        about: "The longest step that holds, by kernel, number of neighbours, speed of sound and solver option, and what a longer one fails by.",
    },
];

/// Runs the command.
pub fn run(args: &ReportArgs) -> Result<Verdict, LabError> {
    let output = Output::new(&args.out)?;
    let mut folders = vec![args.out.clone()];
    folders.extend(args.also.iter().cloned());
    let page = page(&folders)?;
    output.write(FILE, &page.html)?;
    say_files(&output, &[FILE]);
    let mut verdict = Verdict::default();
    verdict.check("charts and pictures on the page", page.figures as f64, "", Bound::AtLeast(1.0));
    Ok(verdict)
}

/// A page and how many charts and pictures it shows.
struct Page {
    /// Links to its sections.
    contents: String,
    html: String,
    figures: usize,
}

fn page(folders: &[PathBuf]) -> Result<Page, LabError> {
    let mut files = Vec::new();
    for folder in folders {
        files.extend(files_of(folder)?);
    }
    let mut page = Page { contents: String::new(), html: String::new(), figures: 0 };
    for picture in files.iter().filter(|path| has_ending(path, "png")) {
        let bytes = fs::read(picture).map_err(LabError::file(picture))?;
        let name = title(&picture.file_stem().unwrap_or_default().to_string_lossy());
        page.html += &format!(
            "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
            escaped(&name),
            STANDARD.encode(bytes)
        );
        page.figures += 1;
    }
    let sections =
        SECTIONS.into_iter().map(|section| (section.stem.to_owned(), section.head.to_owned(), section.about));
    let cases = CASES.iter().map(|case| (case.name.to_owned(), title(case.name), case.about));
    let others = files.iter().filter(|path| has_ending(path, "svg") || has_ending(path, "csv")).map(|path| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let head = title(&stem);
        (stem, head, "")
    });
    let mut shown = BTreeSet::new();
    for (stem, head, about) in sections.chain(cases).chain(others) {
        if shown.insert(stem.clone()) {
            add(&mut page, &files, &stem, &head, about)?;
        }
    }
    page.html = format!("{HEAD}{INTRODUCTION}<nav>{}</nav>\n{}</body>\n</html>\n", page.contents, page.html);
    Ok(page)
}

/// A file's or a case's name as a head line.
fn title(name: &str) -> String {
    let words = name.replace(['_', '-'], " ").replace("dfsph", "DFSPH");
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Files of a folder, by name.
fn files_of(folder: &Path) -> Result<Vec<PathBuf>, LabError> {
    let entries = fs::read_dir(folder).map_err(LabError::file(folder))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|path| path.is_file());
    files.sort();
    Ok(files)
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found == ending)
}

/// The chart and the table of one stem, from the first folder that has them.
fn add(page: &mut Page, files: &[PathBuf], stem: &str, head: &str, about: &str) -> Result<(), LabError> {
    let find = |ending: &str| {
        files.iter().find(|path| path.file_stem().is_some_and(|found| found == stem) && has_ending(path, ending))
    };
    let (chart, table) = (find("svg"), find("csv"));
    if chart.is_none() && table.is_none() {
        return Ok(());
    }
    page.contents += &format!("<a href=\"#{}\">{}</a>\n", escaped(stem), escaped(head));
    page.html += &format!("<section id=\"{}\">\n<h2>{}</h2>\n", escaped(stem), escaped(head));
    if !about.is_empty() {
        page.html += &format!("<p>{}.</p>\n", escaped(&sentence(about)));
    }
    if let Some(path) = chart {
        let svg = fs::read_to_string(path).map_err(LabError::file(path))?;
        // Without what comes before it in a file of its own.
        page.html += &format!("<figure>{}</figure>\n", svg.find("<svg").map_or("", |begin| &svg[begin..]));
        page.figures += 1;
    }
    if let Some(path) = table {
        let csv = fs::read_to_string(path).map_err(LabError::file(path))?;
        page.html += &rows(&csv);
    }
    page.html += "</section>\n";
    Ok(())
}

/// A first letter that is large, and no full stop yet.
fn sentence(text: &str) -> String {
    let mut letters = text.trim_end_matches('.').chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// The first comment as text, the others and the rest as a table that opens when asked.
fn rows(csv: &str) -> String {
    let mut comments = csv
        .lines()
        .filter_map(|line| line.strip_prefix('#'))
        .map(|line| format!("<p class=\"note\">{}</p>\n", code(line.trim())));
    let mut text = comments.next().unwrap_or_default();
    text += "<details><summary>Numbers</summary>\n";
    text.extend(comments);
    text += "<table>\n";
    for (index, line) in csv.lines().filter(|line| !line.starts_with('#')).enumerate() {
        let tag = if index == 0 { "th" } else { "td" };
        let cells: String = cells(line).map(|cell| format!("<{tag}>{}</{tag}>", escaped(&cell))).collect();
        text += &format!("<tr>{cells}</tr>\n");
    }
    text + "</table>\n</details>\n"
}

/// Cells of a line; commas inside quotes part nothing.
fn cells(line: &str) -> impl Iterator<Item = String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            letter => {
                if let Some(cell) = cells.last_mut() {
                    cell.push(letter);
                }
            }
        }
    }
    cells.into_iter()
}

/// Text with what is between backticks as code.
fn code(text: &str) -> String {
    let parts = text.split('`').map(escaped).enumerate();
    parts.map(|(index, part)| if index % 2 == 1 { format!("<code>{part}</code>") } else { part }).collect()
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

const HEAD: &str = r#"<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Freshet in the laboratory</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; color: #22262b; background: #fff; max-width: 1340px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 2rem; margin-bottom: 0; }
h2 { margin: 3rem 0 0; border-top: 1px solid #e2e5e8; padding-top: 1rem; }
p { max-width: 80ch; }
nav { display: flex; flex-wrap: wrap; gap: .4rem 1.2rem; margin: 1.5rem 0; }
a { color: #0b4586; }
figure { margin: 1rem 0; overflow-x: auto; }
figure img, figure svg { display: block; max-width: 100%; height: auto; margin: 0 auto; }
figcaption, .note { color: #5b636b; font-size: .9rem; margin: .2rem 0; }
figcaption { text-align: center; }
code { font: .92em ui-monospace, monospace; background: #f4f5f6; padding: 0 .25em; border-radius: 3px; }
details { margin: .5rem 0; }
summary { cursor: pointer; }
table { border-collapse: collapse; font: 13px/1.4 ui-monospace, monospace; display: block; overflow: auto; max-height: 30rem; margin-top: .5rem; }
td, th { padding: .15rem .6rem; text-align: right; white-space: nowrap; }
th { position: sticky; top: 0; background: #f4f5f6; }
</style>
</head>
<body>
"#;

const INTRODUCTION: &str = "<h1>Freshet in the laboratory</h1>\n<p>Open marks and dashed lines are measurements, exact solutions and bounds; \
                            blue is Freshet, the darker the finer. Under each chart is the command that makes it again.</p>\n";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn charts_tables_and_pictures_are_all_there_and_nothing_from_elsewhere() -> Result<(), LabError> {
        let folder = std::env::temp_dir().join(format!("freshet_lab_report_{}", std::process::id()));
        let output = Output::new(&folder)?;
        output.write("bench.svg", "<?xml version=\"1.0\"?>\n<svg width=\"4\"><text>speed</text></svg>\n")?;
        output.write("bench.csv", "# how it is made: `a < b`\nname,value\n\"one, two\",3\n")?;
        output.write("something_else.svg", "<svg><text>else</text></svg>")?;
        output.write("only_numbers.csv", "a,b\n1,2\n")?;
        output.write("picture_of_water.png", "not really")?;
        let page = page(std::slice::from_ref(&folder))?;
        assert_eq!(page.figures, 3);
        for wanted in [
            "<h2>Speed</h2>",
            "<svg width=\"4\"><text>speed</text></svg>",
            "<h2>Something else</h2>",
            "<h2>Only numbers</h2>",
            "<a href=\"#bench\">Speed</a>",
            "<section id=\"bench\">",
            "how it is made: <code>a &lt; b</code>",
            "<th>name</th><th>value</th>",
            "<td>one, two</td><td>3</td>",
            "alt=\"Picture of water\" src=\"data:image/png;base64,bm90IHJlYWxseQ==\"",
        ] {
            assert!(page.html.contains(wanted), "{wanted} is missing in\n{}", page.html);
        }
        for unwanted in ["<?xml", "http", "<script", "<h2>Peers"] {
            assert!(!page.html.contains(unwanted), "{unwanted} is in\n{}", page.html);
        }
        fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
    }

    #[test]
    fn a_folder_without_figures_misses_the_bound() -> Result<(), LabError> {
        let folder = std::env::temp_dir().join(format!("freshet_lab_report_none_{}", std::process::id()));
        let verdict = run(&ReportArgs { out: folder.clone(), also: Vec::new() })?;
        assert!(!verdict.passes());
        fs::remove_dir_all(&folder).map_err(LabError::file(&folder))?;
        let missing = run(&ReportArgs { out: folder.clone(), also: vec![folder.join("not there")] });
        assert!(missing.is_err_and(|error| error.to_string().contains("not there")));
        fs::remove_dir_all(&folder).map_err(LabError::file(&folder))
    }
}

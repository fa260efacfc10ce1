//! SPlisHSPlasH through its Python package, if there is one.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use glam::Vec3;

use super::run::{FRAME_INTERVAL, Finished, Frame, Task};
use crate::error::LabError;
use crate::progress::Progress;

const SCRIPT: &str = include_str!("splishsplash.py");

fn failed(reason: impl Into<String>) -> LabError {
    LabError::Peer { peer: "SPlisHSPlasH", reason: reason.into() }
}

/// Why it cannot run; none if it can.
pub fn missing(python: &Path) -> Option<String> {
    let probe = Command::new(python).args(["-c", "import pysplishsplash"]).output();
    match probe {
        Ok(output) if output.status.success() => None,
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stderr).into_owned();
            let last = text.lines().last().unwrap_or("no message").to_owned();
            Some(format!("{} cannot import pysplishsplash ({last})", python.display()))
        }
        Err(error) => Some(format!("{}: {error}", python.display())),
    }
}

/// Runs the tank with `method`, `DFSPH` or `WCSPH`; gives the package's version too.
pub fn run(task: &Task, method: &str, python: &Path, progress: &mut Progress) -> Result<(Finished, String), LabError> {
    let file = std::env::temp_dir().join(format!("freshet_peer_{}.frames", std::process::id()));
    let numbers = [task.spacing, task.seconds, FRAME_INTERVAL].map(|number| number.to_string());
    let mut child = Command::new(python)
        .args(["-c", SCRIPT, method])
        .args(numbers)
        .arg(&file)
        .env("OMP_NUM_THREADS", task.threads.to_string())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|error| failed(error.to_string()))?;
    let mut version = String::new();
    if let Some(output) = child.stdout.take() {
        // Its log is in between.
        for line in BufReader::new(output).lines().map_while(Result::ok) {
            match line.split_once(' ') {
                Some(("VERSION", text)) => text.clone_into(&mut version),
                Some(("FRAME", time)) => progress.at(time.parse().unwrap_or(0.0) / task.seconds),
                _ => {}
            }
        }
    }
    let status = child.wait().map_err(|error| failed(error.to_string()))?;
    if !status.success() {
        return Err(failed(format!("ended with {status}")));
    }
    let frames = std::fs::read(&file).map_err(LabError::file(&file))?;
    remove(file)?;
    Ok((finished(&frames, task.particles as usize)?, version))
}

fn remove(file: PathBuf) -> Result<(), LabError> {
    std::fs::remove_file(&file).map_err(LabError::file(&file))
}

/// Reads the frames that the script wrote.
fn finished(bytes: &[u8], particles: usize) -> Result<Finished, LabError> {
    let size = 3 * size_of::<f64>() + particles * size_of::<[f32; 3]>();
    if bytes.is_empty() || !bytes.len().is_multiple_of(size) {
        return Err(failed(format!("{} bytes are no whole number of frames of {size} bytes", bytes.len())));
    }
    let mut finished = Finished::default();
    for record in bytes.chunks_exact(size) {
        let (head, body) = record.split_at(3 * size_of::<f64>());
        let head: Vec<f64> = head.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
        let positions: Vec<[f32; 3]> = body.chunks_exact(12).map(bytemuck::pod_read_unaligned).collect();
        finished.wall = Duration::try_from_secs_f64(head[1]).map_err(|error| failed(error.to_string()))?;
        finished.steps = head[2] as u64;
        let positions = positions.into_iter().map(Vec3::from_array).collect();
        finished.frames.push(Frame { time: head[0], positions });
    }
    Ok(finished)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_read_and_half_a_frame_is_an_error() {
        let mut bytes = Vec::new();
        for frame in 1..=2 {
            for number in [0.05 * f64::from(frame), 1.5 * f64::from(frame), 30.0 * f64::from(frame)] {
                bytes.extend(number.to_le_bytes());
            }
            for number in 0..6 {
                bytes.extend((number as f32).to_le_bytes());
            }
        }
        let read = finished(&bytes, 2).unwrap();
        assert_eq!((read.steps, read.wall), (60, Duration::from_secs(3)));
        assert_eq!(read.frames[1].positions, [Vec3::new(0.0, 1.0, 2.0), Vec3::new(3.0, 4.0, 5.0)]);
        assert!(finished(&bytes[..bytes.len() - 4], 2).is_err());
        assert!(finished(&[], 2).is_err());
    }

    #[test]
    fn a_python_that_is_not_there_is_said_so() {
        let said = missing(Path::new("no_such_python"));
        assert!(said.is_some_and(|text| text.contains("no_such_python")));
    }
}

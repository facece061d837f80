//! Scripts of `--emit`, which run all shards of a sweep on a cluster.

use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result, bail};

use super::quote::shell;
use crate::output::OutputFile;
use crate::report::format::counted;
use crate::shipped;
use crate::shipped::Kind;

/// A program that runs shards: its name, its script, and its default and largest numbers of shards.
struct Engine {
    name: &'static str,
    script: &'static str,
    shards: usize,
    most: usize,
    /// How a word is quoted in the script.
    quoted: fn(&Path) -> String,
}

/// Slurm's default limit on arrays is 1001 (`MaxArraySize`), and many queues refuse more than 999.
const ENGINES: [Engine; 3] = [
    Engine { name: "hq", script: include_str!("hq.sh"), shards: 400, most: 60_000, quoted: shell },
    Engine { name: "slurm", script: include_str!("slurm.sh"), shards: 100, most: 999, quoted: shell },
    Engine { name: "snakemake", script: include_str!("Snakefile"), shards: 100, most: 60_000, quoted: python },
];

/// A script, ready to be written.
pub(super) struct Script(String);

impl Script {
    /// The script of `engine` for the sweep `config` of `points` points with the folder `out`; the options `level`
    /// choose the fidelity level. A shard runs `threads` threads, by default one.
    ///
    /// # Errors
    /// The engine is unknown or takes fewer shards, or a path is not allowed.
    pub(super) fn new(
        engine: &Path,
        (config, level): (&Path, &str),
        out: &Path,
        points: usize,
        (shards, threads): (Option<u16>, Option<u16>),
    ) -> Result<Self> {
        let Some(engine) = ENGINES.iter().find(|known| Path::new(known.name) == engine) else {
            bail!("there is no engine `{}` for `--emit`: hq, slurm and snakemake are allowed", engine.display());
        };
        let shards = shards.map_or(points.clamp(1, engine.shards), usize::from);
        if shards > points.max(1) {
            bail!("`--shards` is {shards}: the sweep has {}", counted(points, "point"));
        }
        if shards > engine.most {
            bail!("`--shards` is {shards}: `--emit {}` takes up to {}", engine.name, engine.most);
        }
        // A line's end in a name would end a comment of the script, and the rest would run as a command.
        if [config, out].iter().any(|path| path.to_string_lossy().contains(char::is_control)) {
            bail!("`--emit`: the name of the config or of the folder has a line's end or another control character");
        }
        // The engine chooses the folder of a job, so paths are absolute. A job runs this very program: shards of
        // another build do not merge.
        let absolute =
            |path: &Path| std::path::absolute(path).with_context(|| format!("cannot find {}", path.display()));
        let is_name = config.to_str().is_some_and(|name| shipped::path(Kind::Experiment, name).is_some());
        let config = if is_name && !config.exists() { config.to_owned() } else { absolute(config)? };
        let program = std::env::current_exe().context("cannot find the program's own file")?;
        let name = config.file_stem().unwrap_or_default().to_string_lossy();
        let name: String =
            name.chars().map(|it| if it.is_ascii_alphanumeric() || it == '-' { it } else { '_' }).collect();
        let script = engine.script.replace("@NAME@", &name).replace("@SHARDS@", &shards.to_string());
        let script = script.replace("@THREADS@", &threads.unwrap_or(1).to_string());
        let level = if engine.name == "snakemake" { python(Path::new(level)) } else { level.into() };
        let script = script.replace("@LEVEL@", &level);
        let script = script.replace("@PROGRAM@", &(engine.quoted)(&program));
        let script = script.replace("@CONFIG@", &(engine.quoted)(&config));
        Ok(Self(script.replace("@OUT@", &(engine.quoted)(&absolute(out)?))))
    }

    /// Writes the script to the file `path`.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn write(&self, path: &Path) -> Result<()> {
        let put = || -> io::Result<()> {
            let mut file = OutputFile::create(path)?;
            file.write_all(self.0.as_bytes())?;
            file.finish()
        };
        put().with_context(|| format!("cannot write {}", path.display()))
    }
}

/// The path as a literal of Python, which accepts the strings of JSON.
fn python(path: &Path) -> String {
    serde_json::Value::from(path.display().to_string()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn script(engine: &str, points: usize, shards: Option<u16>) -> Result<String> {
        let script = Script::new(
            Path::new(engine),
            (Path::new("/a b/words.ron"), " --fidelity Profile"),
            Path::new("/out"),
            points,
            (shards, Some(3)),
        );
        script.map(|script| script.0)
    }

    #[test]
    fn every_place_of_a_script_is_filled() {
        for engine in &ENGINES {
            let script = script(engine.name, 500, Some(7)).unwrap();
            assert!(!script.contains('@'), "{script}");
            for told in ["/a b/words.ron", "/out", "7", "--shard", "--collect", "--fidelity Profile"] {
                assert!(script.contains(told), "{told}: {script}");
            }
        }
    }

    #[test]
    fn shards_are_no_more_than_points_or_what_the_engine_takes() {
        assert!(script("slurm", 20, None).unwrap().contains("#SBATCH --array=1-20\n"));
        assert!(script("slurm", 20_000, None).unwrap().contains("#SBATCH --array=1-100\n"));
        assert!(script("hq", 20_000, None).unwrap().contains("#HQ --array=1-400\n"));
        assert!(script("slurm", 20_000, Some(999)).is_ok());
        let told = script("slurm", 20_000, Some(1000)).unwrap_err().to_string();
        assert_eq!(told, "`--shards` is 1000: `--emit slurm` takes up to 999");
        assert!(script("pbs", 20, None).unwrap_err().to_string().contains("hq, slurm and snakemake are allowed"));
    }
}

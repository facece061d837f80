//! The command line: what a user can ask for, and the flow of each command.

use std::fmt::Display;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result};
use clap::{Args, Parser, Subcommand};

use umbrasim::engine::{Fidelity, ReuseOf, Share};
use umbrasim::experiment::dram_export::{DramExport, TraceFormat};
use umbrasim::experiment::frames::FrameRange;
use umbrasim::experiment::line_export::LineExport;
use umbrasim::experiment::{
    self, Experiment, Overrides, identities, ladder_map, paper, pareto, replay, reuse, run, stress, sweep, trace,
};
use umbrasim::machine::MachineSpec;
use umbrasim::new_file::NewFile;
use umbrasim::quantity::Resolution;
use umbrasim::report;
use umbrasim::stream::{Header, StreamReader, inspect};

/// Simulator of a fixed-function ray-tracing accelerator that culls shadow rays with mode words kept per primitive.
#[derive(Parser)]
#[command(version, max_term_width = 100, after_help = AFTER_HELP)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Threads that trace, validate and replay samples; results don't depend on it [default: one a core]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

const AFTER_HELP: &str = "\
Start with:  umbrasim run configs/experiments/quickstart.ron
then open    reports/quickstart/index.html

Exit status: 0 done; 1 stopped by Ctrl-C, or a simulation failed; 2 a wrong command line, config, scene or stream.";

#[derive(Subcommand)]
enum Command {
    /// Run an experiment: trace its frames, replay them on its machines, validate, and write a report
    ///
    /// Every frame is traced once for all culling policies. Each policy's ray stream is replayed on each machine while it
    /// is traced, and the pictures are compared with those of a renderer of its own code, in double precision. The report
    /// (numbers, plots, pictures and a page that shows all) goes to `reports/NAME`, after the experiment's name. Ctrl-C
    /// ends the run after the frame in work; the report is then of the frames done, and says so.
    Run {
        #[command(flatten)]
        experiment: ExperimentArgs,
        /// Where the report goes [default: reports/NAME]
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Trace an experiment's frames for one policy and record the ray stream in a file
    ///
    /// The file describes itself (`umbrasim inspect`) and is all that `umbrasim replay` needs beside a machine.
    Trace {
        #[command(flatten)]
        experiment: ExperimentArgs,
        /// The stream's file; its folder must be there
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        /// Which policy of the experiment [default: the first]
        #[arg(long, value_name = "NAME")]
        policy: Option<String>,
    },
    /// Replay a recorded ray stream on a machine and print what it measured
    Replay {
        /// The stream's file, from `umbrasim trace`
        stream: PathBuf,
        /// The machine's file, such as configs/machines/small.ron
        #[arg(long, value_name = "FILE")]
        machine: PathBuf,
        /// The rung: Bound, Profile, Event, Cycle (plain, slow, the same numbers), Sampled(engine: Event, rate: 0.05), or Auto(error: 0.02)
        #[arg(long, value_name = "RUNG", default_value_t)]
        fidelity: Fidelity,
        /// Sample, with more and more windows, until the intervals of cycles and of L2 and DRAM bytes are within this share [example: 1%]
        #[arg(long, value_name = "SHARE")]
        target_error: Option<Share>,
        /// Write all measurements to this file too, as JSON
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
        #[command(flatten)]
        dram: DramArgs,
        #[command(flatten)]
        lines: LineArgs,
    },
    /// Measure, in one pass, how a recorded ray stream would miss in caches of all sizes
    ///
    /// The stream is replayed as by the rung Profile; what each cache of the machine is asked for gives reuse distances, and these
    /// the misses of LRU caches of 1 kB to 16 MB in its place, by class of traffic: a table, `reuse.csv` and a plot.
    Profile {
        /// The stream's file, from `umbrasim trace`
        stream: PathBuf,
        /// The machine's file, such as configs/machines/small.ron
        #[arg(long, value_name = "FILE")]
        machine: PathBuf,
        /// Measure a share of the lines only, chosen by a hash [example: 0.01]
        #[arg(long, value_name = "SHARE")]
        sample: Option<Share>,
        /// With a sample: lines that are always in it, those that are asked for most often
        #[arg(long, value_name = "LINES", default_value_t = 4096)]
        hot: usize,
        /// Where the report goes
        #[arg(long, value_name = "DIR", default_value = "reports/profile")]
        out: PathBuf,
    },
    /// Sweep streams made to order over what the rungs of the ladder rest on, and map where each breaks
    ///
    /// Skew, footprint, coherence, caches, rays in flight, miss registers and bursts: how far each rung is from Event, as a
    /// table of the worst, `ladder.csv` and a heat map.
    LadderMap {
        /// Where the map goes
        #[arg(long, value_name = "DIR", default_value = "reports/ladder_map")]
        out: PathBuf,
    },
    /// Compare an experiment's pictures and shadow decisions with the reference renderer's, without machines
    ///
    /// Prints, for each policy, wrong decisions (false dark, false lit: against the same ray traced without culling) and
    /// numeric differences (rounding: the tracer without culling against the reference in double precision).
    Validate {
        #[command(flatten)]
        experiment: ExperimentArgs,
        /// Write a report with the pictures too
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Run every culling policy on every small scene that is known to break one, and write a failure map
    ///
    /// Beside the map, the report shows how far other answers to what the published text leaves open move saving and
    /// error. The command fails if a policy that must never be wrong is.
    Stress {
        /// Where the report goes
        #[arg(long, value_name = "DIR", default_value = "reports/stress")]
        out: PathBuf,
    },
    /// Replay an experiment's streams on machines that differ in named fields, and compare them
    ///
    /// Frames are traced once. Every replay is kept, so that a sweep that was stopped by Ctrl-C goes on when it is started
    /// again. The report has a table (`sweep.csv`), a plot and a page.
    Sweep {
        /// The sweep's file
        #[arg(default_value = "configs/experiments/sweep_words.ron")]
        config: PathBuf,
        /// Where streams, points and the report go [default: reports/, the name of the sweep's file]
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Replay the same streams by every rung, and chart the error of each against its speed
    ///
    /// The report has a table (`pareto.csv`), a chart and a page: errors of cycles, of L2 and DRAM bytes and of what policies save, mean
    /// and worst, beside what the rungs claim; which rung none beats; and where one puts policies or machines in a wrong order.
    Pareto {
        /// The comparison's file
        #[arg(default_value = "configs/experiments/pareto.ron")]
        config: PathBuf,
        /// What the rungs are held to, in place of the file's: Event or Cycle
        #[arg(long, value_name = "RUNG")]
        truth: Option<Fidelity>,
        /// Where the report goes [default: reports/, the name of the comparison's file]
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Say what a recorded ray stream holds
    Inspect {
        /// The stream's file
        stream: PathBuf,
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Print the published figures of GI09 beside ours, under every reading of its text that a config lists
    PaperTable {
        /// The table's file
        #[arg(default_value = "configs/experiments/paper_table.ron")]
        config: PathBuf,
        /// Write all readings to this file too, as JSON
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Replay rays of one kind alone (primary, shadow, diffuse) on the T&I engine, beside its published table
    ///
    /// Holds two identities that tie the table's columns: utilisation is operations a ray times rays a second over the peak, and
    /// DRAM bytes a ray follow from operations and hit rates. The command fails if the first does not hold.
    Identities {
        /// The table's file
        #[arg(default_value = "configs/experiments/identities.ron")]
        config: PathBuf,
        /// Write all rows to this file too, as JSON
        #[arg(long, value_name = "FILE")]
        json: Option<PathBuf>,
    },
    /// Chart what policies save against what they get wrong, over the reports of several runs
    Chart {
        /// Folders of reports, from `umbrasim run`
        #[arg(required = true, value_name = "REPORT_DIR")]
        reports: Vec<PathBuf>,
        /// Where the chart goes
        #[arg(long, value_name = "DIR", default_value = "reports/chart")]
        out: PathBuf,
    },
    /// Say what the numbers of a report mean: unit and definition, and their values in a report
    Explain {
        /// The end of a statistic's path, such as row_hits or bytes.dram.node [default: all statistics]
        name: Option<String>,
        /// A report's folder, to show the values in it
        #[arg(long, value_name = "DIR")]
        report: Option<PathBuf>,
    },
    /// Draw the plots and the page of a report again, from its numbers on disk
    Plot {
        /// The report's folder
        report: PathBuf,
    },
}

#[derive(Args)]
#[command(next_help_heading = "DRAM")]
struct DramArgs {
    /// Write the requests that came to the DRAM to this file, for another DRAM simulator; Event and Cycle only
    ///
    /// A line a burst of the DRAM's part, with the byte address that the machine's `dram.mapping` takes apart, and the clock of the DRAM
    /// in which the request came.
    #[arg(long, value_name = "FILE")]
    dram_trace: Option<PathBuf>,
    /// Who is to read it
    #[arg(long, value_name = "SIMULATOR", default_value = "dramsim3", requires = "dram_trace")]
    dram_trace_format: TraceFormat,
    /// Write the commands that the DRAM was given to this file, as CSV; Event and Cycle only
    ///
    /// Clocks are the DRAM's. A column is a burst's place in its row; the command RDA or WRA closes the row by itself, PREA closes
    /// all rows. Ranks are not modelled. All commands are checked against the timing of the DRAM's part by code of its own, and a
    /// violation is an error.
    #[arg(long, value_name = "FILE")]
    dram_commands: Option<PathBuf>,
}

impl DramArgs {
    /// Begins the files that are wanted.
    fn begin(&self, machine: &MachineSpec) -> Result<Option<DramExport>> {
        if self.dram_trace.is_none() && self.dram_commands.is_none() {
            return Ok(None);
        }
        let trace = self.dram_trace.as_deref().map(|path| (self.dram_trace_format, path));
        Ok(Some(DramExport::create(machine, trace, self.dram_commands.as_deref())?))
    }
}

#[derive(Args)]
#[command(next_help_heading = "Caches")]
struct LineArgs {
    /// Write the lines that a kind of L1 is asked for to this file, for a cache simulator
    ///
    /// In Dinero's form (`0 ADDRESS` reads, `1 ADDRESS` writes, hexadecimal), in the order of the stream: what one such cache would
    /// see if each ray were done before the next one began. It depends on the machine's memory layout, not on its caches.
    #[arg(long, value_name = "FILE")]
    line_trace: Option<PathBuf>,
    /// Which L1s: l1_traversal, l1_list, l1_intersection or l1_shadow_cache
    #[arg(long, value_name = "NAME", default_value = "l1_traversal", requires = "line_trace")]
    line_trace_cache: String,
}

impl LineArgs {
    /// Begins the file that is wanted.
    fn begin(&self, machine: &MachineSpec, header: &Header) -> Result<Option<LineExport>> {
        let begin = |path: &PathBuf| LineExport::create(machine, header, &self.line_trace_cache, path);
        Ok(self.line_trace.as_ref().map(begin).transpose()?)
    }
}

#[derive(Args)]
struct ExperimentArgs {
    /// The experiment's file, such as configs/experiments/quickstart.ron
    #[arg(value_name = "CONFIG")]
    config: PathBuf,
    /// Trace these frames instead of the file's: A..B:STEP, B not included [example: 0..800:16]
    #[arg(long, value_name = "A..B:STEP")]
    frames: Option<FrameRange>,
    /// Trace pictures of this size instead of the file's [example: 512x512]
    #[arg(long, value_name = "WxH")]
    resolution: Option<Resolution>,
}

impl ExperimentArgs {
    fn load(&self) -> Result<Experiment> {
        let overrides = Overrides { frames: self.frames, resolution: self.resolution };
        Ok(Experiment::load(&self.config, overrides)?)
    }
}

/// Runs the command; gives the exit status.
pub fn execute(cli: Cli) -> Result<u8> {
    if let Some(threads) = cli.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads));
        pool.build_global().context("cannot start the threads")?;
    }
    match cli.command {
        Command::Run { experiment, out } => {
            let experiment = experiment.load()?;
            let out = out.unwrap_or_else(|| Path::new("reports").join(&experiment.spec.name));
            run_and_report(&experiment, true, Some(&out))
        }
        Command::Validate { experiment, out } => run_and_report(&experiment.load()?, false, out.as_deref()),
        Command::Trace { experiment, output, policy } => {
            let stop = stop_on_interrupt()?;
            trace::trace(&experiment.load()?, policy.as_deref(), &output, &stop)?;
            print(output.display())?;
            Ok(0)
        }
        Command::Replay { stream, machine, fidelity, target_error, json, dram, lines } => {
            let spec = experiment::read_machine(&machine)?;
            let fidelity = match target_error {
                Some(target) => fidelity.with_target_error(target).map_err(anyhow::Error::msg)?,
                None => fidelity,
            };
            let header = StreamReader::open(&stream)?.header().clone();
            let json = JsonFile::begin(json)?;
            let (mut dram, mut lines) = (dram.begin(&spec)?, lines.begin(&spec, &header)?);
            let stats = replay::replay_file(&spec, fidelity, &stream, dram.as_mut(), lines.as_mut())?;
            print(report::replayed(&spec.name, &header.policy, &stats))?;
            dram.map_or(Ok(()), DramExport::finish)?;
            lines.map_or(Ok(()), LineExport::finish)?;
            json.finish(&stats)?;
            Ok(0)
        }
        Command::Profile { stream, machine, sample, hot, out } => {
            report::check_target(&out)?;
            let spec = experiment::read_machine(&machine)?;
            let of = sample.map_or(ReuseOf::Everything, |rate| ReuseOf::Sample { rate, hot });
            let summary = reuse::reuse(&spec, of, &stream)?;
            print(report::drawn(&report::reuse::grid(&summary)))?;
            report::reuse::write_reuse(&out, &summary)?;
            print(out.join(report::PLOTS_FOLDER).join(report::reuse::PLOT_FILE).display())?;
            Ok(0)
        }
        Command::LadderMap { out } => {
            report::check_target(&out)?;
            let map = ladder_map::run();
            print(report::drawn(&report::ladder_map::grid(&map)))?;
            report::ladder_map::write_map(&out, &map)?;
            print(out.join(report::PLOTS_FOLDER).join(report::ladder_map::PLOT_FILE).display())?;
            Ok(0)
        }
        Command::Stress { out } => {
            report::check_target(&out)?;
            let summary = stress::run();
            report::stress::write_stress(&out, &summary)?;
            let broken = summary.broken();
            broken.iter().for_each(|broken| eprintln!("wrong, and must never be: {broken}"));
            println!("{}", out.join(report::PAGE_FILE).display());
            Ok(u8::from(!broken.is_empty()))
        }
        Command::Sweep { config, out } => {
            let name = config.file_stem().context("the sweep's file has no name")?;
            let out = out.unwrap_or_else(|| Path::new("reports").join(name));
            let stop = stop_on_interrupt()?;
            let summary = sweep::sweep(&config, &out, &stop)?;
            print(report::drawn(&report::sweep::grid(&summary)))?;
            report::sweep::write_sweep(&out, &summary)?;
            print(out.join(report::PAGE_FILE).display())?;
            Ok(0)
        }
        Command::Pareto { config, truth, out } => {
            let name = config.file_stem().context("the comparison's file has no name")?;
            let out = out.unwrap_or_else(|| Path::new("reports").join(name));
            report::check_target(&out)?;
            let stop = stop_on_interrupt()?;
            let (summary, timings) = pareto::pareto(&config, truth, &stop)?;
            print(report::drawn(&summary.grid(&timings)))?;
            report::pareto::write_pareto(&out, &summary, &timings)?;
            print(out.join(report::PAGE_FILE).display())?;
            Ok(0)
        }
        Command::Inspect { stream, json } => {
            let inspection = inspect::inspect(&mut StreamReader::open(&stream)?)?;
            let text = if json { serde_json::to_string_pretty(&inspection)? } else { inspect::render(&inspection) };
            print(text)?;
            Ok(0)
        }
        Command::PaperTable { config, json } => {
            let json = JsonFile::begin(json)?;
            let stop = stop_on_interrupt()?;
            let readings = paper::paper_table(&config, &stop)?;
            print(report::drawn(&paper::grid(&readings)))?;
            print("\ndistance: root mean square of the differences of the four shares, in points")?;
            json.finish(&readings)?;
            Ok(u8::from(stop.load(Ordering::Relaxed)))
        }
        Command::Identities { config, json } => {
            let stop = stop_on_interrupt()?;
            let json = JsonFile::begin(json)?;
            let (rows, published) = identities::identities(&config, &stop)?;
            print(report::drawn(&identities::grid(&rows, &published)))?;
            let worst = rows.iter().map(|row| row.utilization_gap).fold(0.0, f64::max);
            print(format!("largest gap of utilisation: {:.3} points", 100.0 * worst))?;
            json.finish(&rows)?;
            Ok(u8::from(stop.load(Ordering::Relaxed) || worst > identities::MOST_GAP))
        }
        Command::Chart { reports, out } => {
            report::check_target(&out)?;
            let read = |report: PathBuf| report::read_summary(&report.join(report::SUMMARY_FILE));
            let runs = reports.into_iter().map(read).collect::<Result<Vec<_>, _>>()?;
            let chart = report::chart::ChartSummary::new(&runs);
            report::chart::write_chart(&out, &chart)?;
            print(report::drawn(&chart.grid()))?;
            print(out.join(report::PAGE_FILE).display())?;
            Ok(0)
        }
        Command::Explain { name, report } => {
            let numbers = report.map(|report| report::read_numbers(&report.join(report::SUMMARY_FILE))).transpose()?;
            let text = report::explain::explain(name.as_deref(), numbers.as_ref()).map_err(anyhow::Error::msg)?;
            print(text)?;
            Ok(0)
        }
        Command::Plot { report } => {
            report::redraw(&report)?;
            print(report.join(report::PAGE_FILE).display())?;
            Ok(0)
        }
    }
}

fn run_and_report(experiment: &Experiment, machines: bool, out: Option<&Path>) -> Result<u8> {
    if let Some(out) = out {
        report::check_target(out)?;
    }
    let stop = stop_on_interrupt()?;
    let result = run::run(experiment, machines, &stop)?;
    print(report::terminal(&result.summary))?;
    if let Some(out) = out {
        report::write_report(out, &result)?;
        print(out.join(report::PAGE_FILE).display())?;
    }
    Ok(u8::from(stop.load(Ordering::Relaxed)))
}

/// Prints a line. A reader that has gone away (`| head`) wants no more, which is no error.
fn print(text: impl Display) -> Result<()> {
    match writeln!(io::stdout(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to standard output")
        }
        _ => Ok(()),
    }
}

/// A file for measurements, if the user wants one. It is begun before the work, which would be lost if it could not be.
struct JsonFile(Option<(PathBuf, NewFile)>);

impl JsonFile {
    fn begin(path: Option<PathBuf>) -> Result<Self> {
        let begin = |path: PathBuf| {
            let file = NewFile::create(&path).with_context(|| format!("cannot write {}", path.display()))?;
            anyhow::Ok((path, file))
        };
        Ok(Self(path.map(begin).transpose()?))
    }

    fn finish(self, measured: &impl serde::Serialize) -> Result<()> {
        let Some((path, mut file)) = self.0 else { return Ok(()) };
        let text = serde_json::to_string_pretty(measured)?;
        file.write_all(text.as_bytes())
            .and_then(|()| file.finish())
            .with_context(|| format!("cannot write {}", path.display()))
    }
}

/// A flag that the first Ctrl-C sets; the second one ends the program at once.
fn stop_on_interrupt() -> Result<Arc<AtomicBool>> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        eprintln!("stopping after this frame; once more to stop at once");
    })
    .context("cannot watch for Ctrl-C")?;
    Ok(stop)
}

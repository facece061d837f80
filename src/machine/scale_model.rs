//! Scale models: a machine with few cores that predicts one with many cores.
//!
//! A core of the model equals a core of the large machine and traces the same number of rays. Resources that all cores
//! share and that an address selects keep their number and run at the model's share of the speed. These are the DRAM
//! channels and the shadow-cache units, each of which owns some words. So each of them sees the same lines as in the
//! large machine, and the busiest one is equally busy. Fewer of them at full speed would spread hot lines better. The
//! queue in front of a channel has the same length per core as in the large machine.
//!
//! Unchanged, since latency matters most there: rows of the DRAM, its activates and refreshes; contexts and MSHRs of
//! shadow-cache units.

use super::shadow_cache::{FrameEnd, Place, ShadowCacheSpec};
use super::spec::{MachineSpec, SpecError};
use crate::memory::dram::mapping::{Field, Mapping};
use crate::memory::dram::part::{DramPart, Timing};
use crate::memory::dram::spec::{DramSpec, Model};
use crate::ranged::{PowerOfTwo, Size, Within};

impl MachineSpec {
    /// The machine with `cores` cores and `channels` DRAM channels. Without `channels`, the number of channels per core
    /// is kept.
    ///
    /// The mapping of a machine with one channel has no channel bits. They are inserted above the first `Column`, so
    /// that neighbouring lines of a row stay together.
    ///
    /// # Errors
    /// The numbers of cores or channels are out of range, or the machine's fields then contradict each other.
    pub fn with_cores(&self, cores: u64, channels: Option<u64>) -> Result<Self, SpecError> {
        let number = || {
            let all = self.dram.channels.get() * cores;
            if all.is_multiple_of(self.cores.get()) {
                Ok(all / self.cores.get())
            } else {
                Err(format!(
                    "{} for {} cores, of which {cores} would have no whole number",
                    self.dram.channels, self.cores
                ))
            }
        };
        let large = || {
            let cores = Within::new(cores).map_err(|why| format!("`cores`: {why}"))?;
            let channels = channels.map_or_else(number, Ok).and_then(PowerOfTwo::new);
            let channels = channels.map_err(|why| format!("`dram.channels`: {why}"))?;
            let mapping = match self.dram.model {
                Model::Banks if channels != self.dram.channels => self.dram.mapping.with_channels(channels.get()),
                Model::Banks | Model::Flat { .. } => self.dram.mapping.clone(),
            };
            Ok(Self { cores, dram: DramSpec { channels, mapping, ..self.dram.clone() }, ..self.clone() })
        };
        let large =
            large().map_err(|why: String| SpecError::new(format!("{} with {cores} cores: {why}", self.name)))?;
        large.check().map(|()| large)
    }

    /// A model of the machine with `cores` of its cores. It predicts the machine if it replays the same share of the
    /// rays: see the module's documentation.
    ///
    /// # Errors
    /// A shared resource cannot be divided by the ratio of the numbers of cores.
    pub fn scale_model(&self, cores: u64) -> Result<Self, SpecError> {
        let name = |why: String| {
            SpecError::new(format!("{} of {} cores has no model of {cores}: {why}", self.name, self.cores))
        };
        self.model(cores).map_err(name)
    }

    fn model(&self, cores: u64) -> Result<Self, String> {
        let all = self.cores.get();
        if !(1..all).contains(&cores) || !all.is_multiple_of(cores) {
            return Err(format!("a number below {all} is allowed that divides it"));
        }
        if self.traffic.is_on() {
            return Err(
                "`traffic` is on, whose port is one, whatever the number of cores: `traffic: ()` is allowed".into()
            );
        }
        let sweeps = self.shadow_cache.frame_end == FrameEnd::Sweep && self.shadow_cache.place != Place::Free;
        if sweeps {
            return Err(
                "`shadow_cache.frame_end` is Sweep, which sets all words, however many rays there are: List and \
                        Epoch are allowed"
                    .into(),
            );
        }
        let share = all / cores;
        let model = Self {
            cores: Within::new(cores)?,
            shadow_cache: self.shadow_cache.slowed(share)?,
            dram: self.dram.slowed(share)?,
            ..self.clone()
        };
        model.check().map(|()| model).map_err(|error| error.to_string())
    }
}

impl ShadowCacheSpec {
    /// `share` times the units per core, each at 1/`share` of the operation rate; the ports of the L1 can limit that
    /// rate.
    fn slowed(&self, share: u64) -> Result<Self, String> {
        let (width, interval, ports) = (self.width.get(), self.interval.get(), self.cache.accesses_per_cycle());
        let by_port = self.place == Place::Own && ports * interval < width;
        let (operations, cycles) = if by_port { (ports, share) } else { (width, interval * share) };
        let common = greatest_divisor(operations, cycles);
        let within = |field: &str, why: String| format!("`shadow_cache.{field}`: {why}");
        let interval = Within::new(cycles / common).map_err(|why| within("interval", why))?;
        Ok(Self {
            count: Within::new(self.count.get() * share).map_err(|why| within("count", why))?,
            width: Within::new(operations / common).map_err(|why| within("width", why))?,
            latency: self.latency.max(interval),
            interval,
            ..*self
        })
    }
}

impl DramSpec {
    /// The same channels, each with a bus `share` times as slow and 1/`share` of the queue.
    fn slowed(&self, share: u64) -> Result<Self, String> {
        let model = match self.model {
            Model::Flat { latency, bytes_per_cycle: Some(bytes) } => {
                let narrow = bytes.get() / share;
                if narrow * share != bytes.get() {
                    return Err(format!("`dram.model` moves {bytes} bytes a cycle, which {share} does not divide"));
                }
                Model::Flat { latency, bytes_per_cycle: Some(Size::new(narrow)?) }
            }
            model @ (Model::Flat { .. } | Model::Banks) => model,
        };
        let queue = self.queue.get() / share;
        if queue * share != self.queue.get() {
            return Err(format!("`dram.queue` is {}, which {share} does not divide", self.queue));
        }
        let DramPart { burst_clocks, timing, .. } = &self.part;
        let longer = burst_clocks.get() * (share - 1);
        let part = || {
            let timing = Timing {
                ccd_s: Within::new(timing.ccd_s.get() + longer)?,
                ccd_l: Within::new(timing.ccd_l.get() + longer)?,
                ..*timing
            };
            Ok(DramPart { burst_clocks: Within::new(burst_clocks.get() + longer)?, timing, ..self.part.clone() })
        };
        let part = part().map_err(|why: String| format!("`dram.part.burst_clocks`: {why}"))?;
        Ok(Self { model, part, queue: Within::new(queue)?, ..self.clone() })
    }
}

impl Mapping {
    /// The mapping with the bits of `channels` channels, in place of its channel bits or else above the first `Column`.
    fn with_channels(&self, channels: u64) -> Self {
        let is_channel = |field: &Field| matches!(field, Field::Channel(_));
        let column = || self.0.iter().position(|field| matches!(field, Field::Column(_))).map(|at| at + 1);
        let at = self.0.iter().position(is_channel).or_else(column).unwrap_or_default();
        let mut fields: Vec<Field> = self.0.iter().copied().filter(|field| !is_channel(field)).collect();
        if channels > 1 {
            fields.insert(at, Field::Channel(channels.trailing_zeros()));
        }
        Self(fields)
    }
}

fn greatest_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::ron_file;

    fn machine(text: &str) -> MachineSpec {
        ron_file::parse(text, Path::new("x.ron")).unwrap()
    }

    fn error(result: Result<MachineSpec, SpecError>) -> String {
        result.unwrap_err().to_string()
    }

    #[test]
    fn more_cores_have_channels_in_proportion_above_the_first_column() {
        let small = machine("(name: \"m\", cores: 2)");
        let large = small.with_cores(16, None).unwrap();
        assert_eq!((large.cores.get(), large.dram.channels.get()), (16, 8));
        assert_eq!(large.dram.mapping.to_string(), "Column(1) Channel(3) Bank(3) Column(4) Row");
        assert_eq!(large.with_cores(4, Some(1)).unwrap().dram.mapping, small.dram.mapping);
        assert_eq!(small.with_cores(2, None), Ok(small.clone()));
        assert!(error(small.with_cores(3, None)).contains("m with 3 cores: `dram.channels`: 1 for 2 cores"));
        assert!(error(small.with_cores(64, Some(128))).contains("a power of two from 1 to 64"));
        assert!(error(small.with_cores(65, Some(1))).contains("`cores`: 65 is not allowed"));
    }

    #[test]
    fn what_is_shared_keeps_its_number_and_has_a_share_of_the_speed() {
        let large = machine("(cores: 16, shadow_cache: (count: 2, width: 3, cache: (ports: 2)), dram: (model: Banks))");
        let model = large.scale_model(2).unwrap();
        let (unit, of) = (&model.shadow_cache, &large.shadow_cache);
        assert_eq!(model.cores.get() * unit.count.get(), large.cores.get() * of.count.get(), "each word has its owner");
        // Two ports let through two of the three operations a cycle: an eighth of that is one in four cycles.
        assert_eq!((unit.width.get(), unit.interval.get(), unit.latency.get()), (1, 4, 4));
        assert_eq!((model.dram.channels, &model.dram.mapping), (large.dram.channels, &large.dram.mapping));
        assert_eq!((model.dram.queue.get(), large.dram.queue.get()), (4, 32));
        let peak = |machine: &MachineSpec| machine.dram.peak_bytes_per_cycle(500).unwrap();
        assert!((peak(&model) * 8.0 - peak(&large)).abs() < 1e-9);
        assert_eq!((model.traversal.count, &model.l2), (large.traversal.count, &large.l2), "what a core owns is kept");
    }

    #[test]
    fn what_does_not_divide_is_refused_by_its_name() {
        let refused = |text: &str, cores| error(machine(text).scale_model(cores));
        let cases = [
            ("(cores: 4)", 4, "a number below 4 is allowed that divides it"),
            ("(cores: 4)", 3, "a number below 4 is allowed that divides it"),
            ("(cores: 4, traffic: (pixel_bytes: 4))", 2, "`traffic` is on"),
            ("(cores: 4, shadow_cache: (frame_end: Sweep))", 2, "`shadow_cache.frame_end` is Sweep"),
            ("(cores: 64, shadow_cache: (count: 4))", 2, "`shadow_cache.count`: 128 is not allowed"),
            ("(cores: 64, dram: (model: Flat(latency: 9, bytes_per_cycle: 16)))", 2, "16 bytes a cycle, which 32 does"),
            ("(cores: 64, dram: (queue: 48))", 2, "`dram.queue` is 48, which 32 does not divide"),
        ];
        for (text, cores, expected) in cases {
            let error = refused(text, cores);
            assert!(error.contains(expected) && error.contains("has no model of"), "{text}: {error}");
        }
    }
}

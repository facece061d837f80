//! The files of a stress report.

use minijinja::{Value, context};
use serde::Serialize;

use super::columns::lines;
use super::data::{CaseSummary, Effect, FrameWrong, ModelVerdict, Outcome, StressPolicy, StressSummary};
use super::section::Section;
use super::{failure_map, over_frames};
use crate::report::csv_table::CsvTable;
use crate::report::draw::palette::css;
use crate::report::draw::{DrawError, Drawing, Plot, draw_all};
use crate::report::error::ReportError;
use crate::report::format::{exact, percent};
use crate::report::grid::Grid;
use crate::report::results;
use crate::report::template;
use crate::report::writer::{Report, ReportFile};

const PLOTS: &[Plot<StressSummary, Section>] = &[failure_map::PLOT, over_frames::PLOT];

impl Report for StressSummary {
    type Section = Section;

    fn numbers(&self) -> &impl Serialize {
        self
    }

    fn tables(&self) -> Vec<CsvTable> {
        Vec::new()
    }

    fn attachments(&self) -> Result<Vec<ReportFile>, ReportError> {
        results::files(self)
    }

    fn plots(&self) -> Result<Vec<Drawing<Section>>, DrawError> {
        draw_all(self, PLOTS)
    }

    fn page(&self, plots: &[Drawing<Section>]) -> Result<Option<String>, minijinja::Error> {
        let matters = |matters: fn(&Effect) -> bool| -> Vec<String> {
            self.effects.iter().filter(|effect| matters(effect)).map(|effect| effect.option.clone()).collect()
        };
        let effect = |effect: &Effect| -> Vec<String> {
            let points = |share: f64| format!("{:+.2}", share * 100.0);
            let Effect { option, saving, wrong_per_million: wrong } = effect;
            vec![
                option.clone(),
                format!("{} \u{b1} {:.2}", points(saving.mean), saving.error * 100.0),
                format!("{:+.0} \u{b1} {:.0}", wrong.mean, wrong.error),
            ]
        };
        let totals = |(column, policy): (usize, &StressPolicy)| -> Vec<String> {
            let frames = || self.cases.iter().flat_map(|case| &case.policies[column]);
            let rays: u64 = frames().map(|frame| frame.shadow_rays).sum();
            let [dark, lit] =
                [frames().map(|frame| frame.false_dark).sum(), frames().map(|frame| frame.false_lit).sum()];
            let failed = |case: &&CaseSummary| Outcome::of(&case.policies[column]) != Outcome::Right;
            vec![
                policy.name.clone(),
                if policy.exact { "never".into() } else { "allowed".into() },
                exact(self.cases.iter().filter(failed).count() as u64),
                exact(dark),
                exact(lit),
                percent((dark + lit) as f64 / rays.max(1) as f64),
            ]
        };
        let verdict = |verdict: &ModelVerdict| match verdict {
            ModelVerdict::Agrees => "the same".into(),
            ModelVerdict::Differs(share) => format!("cycles off by {}", percent(*share)),
            ModelVerdict::Failed(why) => format!("failed: {why}"),
        };
        let cell = |frames: &Vec<FrameWrong>| {
            let outcome = Outcome::of(frames);
            context! { text => failure_map::text(outcome), color => css(failure_map::look(outcome)) }
        };
        let case = |case: &CaseSummary| {
            let cells: Vec<Value> = case.policies.iter().map(cell).collect();
            context! { name => case.name.as_str(), title => case.title.as_str(), cells }
        };
        let verdicts = |case: &CaseSummary| -> Vec<String> {
            std::iter::once(case.name.clone()).chain(case.models.iter().skip(1).map(verdict)).collect()
        };
        let names = |first: &str, names: &mut dyn Iterator<Item = String>| -> Vec<String> {
            std::iter::once(first.to_owned()).chain(names).collect()
        };
        let table = |head: Vec<String>, rows: Vec<Vec<String>>| template::grid(Grid { head, names: 1, rows });
        let totals_head = ["policy", "may be wrong", "cases failed", "false dark", "false lit", "wrong share"];
        let effects_head = ["answer", "traversal saved, points", "wrong a million rays"];
        let context = context! {
            verdict => failure_map::verdict(self),
            looks => template::key(&failure_map::key()),
            policies => self.policies.iter().map(|policy| lines(&policy.name)).collect::<Vec<_>>(),
            over_frames => template::plots(plots, &Section::OverFrames),
            broken => self.broken(),
            totals => table(
                totals_head.map(Into::into).to_vec(),
                self.policies.iter().enumerate().map(totals).collect(),
            ),
            effects => table(effects_head.map(Into::into).to_vec(), self.effects.iter().map(effect).collect()),
            effect_scenes => self.effect_scenes,
            saving_matters => matters(|effect| effect.saving.matters()),
            wrong_matters => matters(|effect| effect.wrong_per_million.matters()),
            models => self.models.iter().map(|model| model.name.clone()).collect::<Vec<_>>(),
            cases => self.cases.iter().map(case).collect::<Vec<_>>(),
            verdicts => table(
                names("case", &mut self.models.iter().skip(1).map(|model| model.name.clone())),
                self.cases.iter().map(verdicts).collect(),
            ),
        };
        template::render("stress.html", include_str!("page.html"), context).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::super::data::tests::summary;
    use super::*;
    use crate::output::{FolderError, ResultsFolder};
    use crate::report::writer::{SUMMARY_FILE, write};

    #[test]
    fn the_report_holds_everything_and_replaces_itself_only() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("stress");
        let pages = [(); 2].map(|()| write(&ResultsFolder::claim(&target).unwrap(), &summary()).unwrap());
        let text = std::fs::read(target.join(SUMMARY_FILE)).unwrap();
        assert_eq!(serde_json::from_slice::<StressSummary>(&text).unwrap(), summary());
        let page = std::fs::read_to_string(&pages[1]).unwrap();
        for part in ["cycles off by 50.0 %", "C8", "a dynamic blocker leaves", "partial: Sticky", "+25.00", "78"] {
            assert!(page.contains(part), "{part}");
        }
        let foreign = folder.path().join("foreign");
        std::fs::create_dir(&foreign).unwrap();
        std::fs::write(foreign.join("notes.txt"), "mine").unwrap();
        assert!(matches!(ResultsFolder::claim(&foreign), Err(FolderError::Foreign { .. })));
    }
}

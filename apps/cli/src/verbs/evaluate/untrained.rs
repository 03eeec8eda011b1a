//! The chapters that train networks, in a build that cannot.

use anyhow::Result;
use deeptree_eval::report::Chapter;

use super::study::Study;

/// A chapter that says how to have it.
fn without_training(study: &Study<'_>, name: &'static str, title: &str) -> Chapter {
    let mut chapter = Chapter::new(name, title);
    chapter.text(format!(
        "Not measured: this chapter trains networks, and this build cannot. A build that can goes \
         on with this report: cargo run --release --features train -- evaluate --chapters {name} \
         -o {}",
        study.verb.output.display()
    ));
    chapter
}

pub(super) mod ablation {
    use super::{Chapter, Result, Study};

    pub(crate) fn chapter(study: &Study<'_>) -> Result<Chapter> {
        Ok(super::without_training(study, "ablation", "Ablations of the node's attributes"))
    }
}

pub(super) mod joint {
    use super::{Chapter, Result, Study};

    pub(crate) fn chapter(study: &Study<'_>) -> Result<Chapter> {
        Ok(super::without_training(study, "joint", "One joint network against the cascade"))
    }
}

use deeptree_generate::{Limits, Request, generate};
use deeptree_graph::Seed;
use deeptree_infer::{Model, Predictor, Workspace};
fn main() {
    let model = Model::from_bytes(&std::fs::read("models/situated.safetensors").unwrap()).unwrap();
    let args: Vec<String> = std::env::args().collect();
    let trees: u64 = args[1].parse().unwrap();
    let mut work = Workspace::default();
    for name in ["beech", "corkscrew", "maple", "oak", "pine", "tulip", "walnut", "willow"] {
        for g in [None, Some(-0.4f32), Some(-0.2), Some(0.0), Some(0.2), Some(0.4)] {
            let (mut told, mut grown, mut tips, mut low) = (0.0, 0.0, 0.0, 0.0);
            for s in 0..trees {
                let mut r = Request::new(name, Seed(9_000_000 + s));
                r.gravitropism = g;
                let t = generate(&model, &r, Limits::default(), &mut work).unwrap();
                told += t.germ.root.traits.nodes as f64;
                grown += t.tree.len() as f64;
                tips += t.avoided.given_up as f64;
                low += t.tree.nodes().iter().filter(|n| n.position.y < 1.0).count() as f64;
            }
            let n = trees as f64;
            println!(
                "{name} {g:?} told {:.0} grown {:.0} ({:+.1}%) given up {:.1} low {:.0}",
                told / n,
                grown / n,
                100.0 * (grown / told - 1.0),
                tips / n,
                low / n
            );
        }
    }
    let _ = model.species();
}

//! Reconstructs the clouds named (plain `x y z` rows, z up) and prints how well each fits.
use deeptree_graph::Vec3;
use deeptree_mesh::{WoodOptions, wood};
use deeptree_reconstruct::{Fit, Options, fit::SAMPLES, reconstruct};
use std::time::Instant;

fn main() {
    for path in std::env::args().skip(1) {
        let text = std::fs::read_to_string(&path).expect("a file of points");
        let rows: Vec<[f64; 3]> = text
            .lines()
            .map(|line| {
                let mut n = line.split_whitespace().map(|w| w.parse().expect("a number"));
                [0; 3].map(|_| n.next().expect("three numbers"))
            })
            .collect();
        let first = rows[0];
        let cloud: Vec<Vec3> = rows
            .iter()
            .map(|p| Vec3::new((p[0] - first[0]) as f32, p[2] as f32, -(p[1] - first[1]) as f32))
            .collect();
        let start = Instant::now();
        let mut options = Options::default();
        if let Ok(c) = std::env::var("COVER") {
            options.cover = Some(c.parse().expect("number"));
        }
        let model = deeptree_infer::Model::from_bytes(include_bytes!(
            "../../../models/situated.safetensors"
        ))
        .unwrap();
        if std::env::var("PRIOR").is_ok() {
            options.prior = Some(&model);
            options.complete = std::env::var("COMPLETE").is_ok();
            options.species = std::env::var("SPECIES").ok();
        }
        let start = Instant::now();
        let made = reconstruct(&cloud, &options).expect("a tree");
        let seconds = start.elapsed().as_secs_f64();
        let height = {
            let ys = || cloud.iter().map(|p| p.y);
            ys().fold(f32::MIN, f32::max) - ys().fold(f32::MAX, f32::min)
        };
        let options = WoodOptions { foot_flare: 1.0, fluting: 0.0, ..WoodOptions::default() };
        let mesh = wood(&made.tree, &options);
        let local: Vec<Vec3> = cloud.iter().map(|p| *p - made.foot).collect();
        let fit = Fit::new(&local, &mesh, SAMPLES);
        let length: f32 = made.tree.nodes().iter().map(|n| n.length).sum();
        let t = [0.01 * height, 0.05];
        println!(
            "{path}: F {:.4} {:.4} | recall {:.4} {:.4} precision {:.4} {:.4} | {length:.0} m, {} nodes, {seconds:.3} s, vol {:.3} area {:.2} r0 {:.3}",
            fit.f_score(t[0]),
            fit.f_score(t[1]),
            fit.cloud_to_tree.share_within(t[0]),
            fit.cloud_to_tree.share_within(t[1]),
            fit.tree_to_cloud.share_within(t[0]),
            fit.tree_to_cloud.share_within(t[1]),
            made.tree.len(),
            mesh.volume(),
            mesh.area(),
            made.tree.root().thickness,
        );
        print!(
            "  {} added {} figures {:?}\n",
            made.tree.info.species,
            made.completed,
            deeptree_reconstruct::Figures::of(&made.tree)
        );
        if let Ok(out) = std::env::var("DUMP") {
            let name =
                std::path::Path::new(&path).file_stem().unwrap().to_string_lossy().to_string();
            let mut s = String::new();
            for n in made.tree.nodes() {
                let b = n.base() + made.foot;
                let p = n.position + made.foot;
                s += &format!(
                    "{} {} {} {} {} {} {} {}\n",
                    b.x, b.y, b.z, p.x, p.y, p.z, n.thickness, n.order
                );
            }
            std::fs::write(format!("{out}/{name}.skel"), s).unwrap();
            let mut s = String::new();
            for p in &cloud {
                s += &format!("{} {} {}\n", p.x, p.y, p.z);
            }
            std::fs::write(format!("{out}/{name}.pts"), s).unwrap();
        }
    }
}

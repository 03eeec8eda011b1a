//! Scans grown trees from one side and reconstructs them.
use deeptree_graph::{Seed, Vec3};
use deeptree_growth::{Profile, Species, grow};
use deeptree_infer::Model;
use deeptree_mesh::{WoodOptions, tubes, wood};
use deeptree_reconstruct::{
    Options,
    fit::{Fit, SkeletonFit},
    reconstruct,
};
use obvhs::{
    aabb::Aabb,
    bvh2::Bvh2,
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
    ray::Ray,
};
use std::time::Instant;

fn scan(triangles: &[[Vec3; 3]], from: Vec3, rays: u32) -> Vec<Vec3> {
    let boxes: Vec<Aabb> = triangles
        .iter()
        .map(|[a, b, c]| Aabb::new(a.min(*b).min(*c).into(), a.max(*b).max(*c).into()))
        .collect();
    let bvh: Bvh2 = PlocBuilder::new().build(
        PlocSearchDistance::Low,
        &boxes,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        0,
    );
    let (lo, hi) = triangles
        .iter()
        .flatten()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    let mut out = Vec::new();
    let n = rays;
    for i in 0..n {
        let y = 1.0 - 2.0 * (i as f32 + 0.5) / n as f32;
        let phi = i as f32 as f64 * 2.399963229728653;
        let r = (1.0 - y * y).sqrt();
        let d = Vec3::new(r * (phi.cos() as f32), y, r * (phi.sin() as f32));
        // cull
        let c = (lo + hi) / 2.0 - from;
        if d.dot(c) < 0.0 {
            continue;
        }
        let mut best = f32::INFINITY;
        bvh.ray_traverse_miss(Ray::new(from.into(), d.into(), 0.0, 1000.0), |_, at| {
            let [a, b, c] = triangles[bvh.primitive_indices[at] as usize];
            let (ab, ac) = (b - a, c - a);
            let p = d.cross(ac);
            let det = ab.dot(p);
            if det.abs() < 1e-12 {
                return f32::INFINITY;
            }
            let t = from - a;
            let u = t.dot(p) / det;
            let q = t.cross(ab);
            let v = d.dot(q) / det;
            let s = ac.dot(q) / det;
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && s > 0.0 && s < best {
                best = s;
            }
            f32::INFINITY
        });
        if best.is_finite() {
            out.push(from + d * best);
        }
    }
    out
}

fn main() {
    let trees: u64 = std::env::args().nth(1).map_or(1, |n| n.parse().unwrap());
    let model = Model::from_bytes(include_bytes!("../../../models/situated.safetensors")).unwrap();
    let prior = std::env::var("PRIOR").is_ok();
    let mut sums = vec![0.0f64; 17];
    let mut count = 0.0;
    for name in ["beech", "corkscrew", "maple", "oak", "pine", "tulip", "walnut", "willow"] {
        let species = Species::named(name).unwrap();
        let mut own = vec![0.0f64; 17];
        for seed in 0..trees {
            let tree = grow(name, species.parameters(Profile::Reference), Seed(900_000 + seed))
                .unwrap()
                .tree;
            let mesh = tubes(&tree, &WoodOptions::default());
            let triangles: Vec<[Vec3; 3]> = mesh.triangles().collect();
            let (lo, hi) = mesh.bounds().unwrap();
            let from = Vec3::new(hi.x.max(-lo.x) + 5.0, 1.5, 3.0);
            let pts: usize = std::env::var("PTS").map_or(20_000, |p| p.parse().unwrap());
            let mut rays = 10_000;
            let mut cloud = scan(&triangles, from, rays);
            if cloud.len() < pts {
                rays = (rays as f64 * pts as f64 / cloud.len() as f64) as u32;
                cloud = scan(&triangles, from, rays.min(3_000_000));
            }
            let mut options = Options::default();
            if prior {
                options.prior = Some(&model);
                options.complete = std::env::var("COMPLETE").is_ok();
                if std::env::var("KNOWN").is_ok() {
                    options.species = Some(name.into());
                }
            }
            let start = Instant::now();
            let made = reconstruct(&cloud, &options).unwrap();
            let seconds = start.elapsed().as_secs_f64();
            let height = hi.y - lo.y;
            let moved = made.tree.clone().moved(made.foot);
            let s = SkeletonFit::new(&moved, &tree, 0.01 * height);
            let wood_made = wood(
                &moved,
                &WoodOptions { foot_flare: 1.0, fluting: 0.0, ..WoodOptions::default() },
            );
            let f = Fit::new(&cloud, &wood_made, 20_000);
            let length = |t: &deeptree_graph::BranchGraph| {
                t.nodes().iter().map(|n| f64::from(n.length)).sum::<f64>()
            };
            let top = |t: &deeptree_graph::BranchGraph| {
                t.nodes().iter().map(|n| n.position.y).fold(0.0, f32::max)
            };
            let dbh = |t: &deeptree_graph::BranchGraph| {
                t.nodes()
                    .iter()
                    .filter(|n| n.order == 0)
                    .min_by(|a, b| {
                        (a.position.y - 1.3).abs().total_cmp(&(b.position.y - 1.3).abs())
                    })
                    .unwrap()
                    .thickness
            };
            let o = |i: usize| s.recall_of_order[i].unwrap_or(0.0);
            let row = [
                s.f_score(),
                s.precision,
                s.recall,
                o(0),
                o(1),
                o(2),
                o(3),
                o(4),
                f.f_score(0.01 * height),
                length(&moved) / length(&tree),
                f64::from(top(&moved) / top(&tree)),
                f64::from(dbh(&moved) / dbh(&tree)),
                wood_made.volume()
                    / wood(
                        &tree,
                        &WoodOptions { foot_flare: 1.0, fluting: 0.0, ..WoodOptions::default() },
                    )
                    .volume(),
                seconds,
                cloud.len() as f64,
                s.same_way,
                s.same_order,
            ];
            for (a, b) in own.iter_mut().zip(row) {
                *a += b / trees as f64;
            }
            if let Ok(out) = std::env::var("DUMP")
                && seed == 0
            {
                for (kind, t) in [("made", &moved), ("true", &tree)] {
                    let mut s = String::new();
                    for n in t.nodes() {
                        let b = n.base();
                        let p = n.position;
                        s += &format!(
                            "{} {} {} {} {} {} {} {}\n",
                            b.x, b.y, b.z, p.x, p.y, p.z, n.thickness, n.order
                        );
                    }
                    std::fs::write(format!("{out}/{name}_{kind}.skel"), s).unwrap();
                    let mut s = String::new();
                    for p in &cloud {
                        s += &format!("{} {} {}\n", p.x, p.y, p.z);
                    }
                    std::fs::write(format!("{out}/{name}_{kind}.pts"), s).unwrap();
                }
            }
        }
        let f: Vec<String> = own.iter().map(|x| format!("{x:.3}")).collect();
        println!(
            "{name:9} F {} p {} r {} | by order {} {} {} {} {} | surf F {} len {} top {} dbh {} vol {} {} s {} pts way {} order {}",
            f[0],
            f[1],
            f[2],
            f[3],
            f[4],
            f[5],
            f[6],
            f[7],
            f[8],
            f[9],
            f[10],
            f[11],
            f[12],
            f[13],
            f[14],
            f[15],
            f[16]
        );
        for (a, b) in sums.iter_mut().zip(own) {
            *a += b;
        }
        count += 1.0;
    }
    let f: Vec<String> = sums.iter().map(|x| format!("{:.3}", x / count)).collect();
    println!(
        "{:9} F {} p {} r {} | by order {} {} {} {} {} | surf F {} len {} top {} dbh {} vol {} {} s {} pts way {} order {}",
        "mean",
        f[0],
        f[1],
        f[2],
        f[3],
        f[4],
        f[5],
        f[6],
        f[7],
        f[8],
        f[9],
        f[10],
        f[11],
        f[12],
        f[13],
        f[14],
        f[15],
        f[16]
    );
}

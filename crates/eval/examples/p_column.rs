use deeptree_eval::{Row, Table, TreeMetrics};
use deeptree_graph::Seed;
use deeptree_growth::{Profile, SPECIES, Species, grow};
fn main() {
    let n: u64 = std::env::args().nth(1).unwrap().parse().unwrap();
    let mut table = Table::default();
    for name in SPECIES {
        let s = Species::named(name).unwrap();
        let t = std::time::Instant::now();
        let mut row = Row::new(name, "P");
        for seed in 0..n {
            let g = grow(name, s.parameters(Profile::Reference), Seed(seed)).unwrap();
            row.add(&TreeMetrics::of(&g.tree), g.hit_budget);
        }
        eprintln!("{name} {:.1} ms", t.elapsed().as_secs_f64() * 1000.0 / n as f64);
        table.rows.push(row);
    }
    println!("{}", table.text());
}

use deeptree_dataset::{Corpus, Split};
use deeptree_graph::{TreeTraits, signature::tip_count};
fn main() {
    println!("species,split,age,v,tips,nodes,longest,branches,mean_path,crown,height,trunk");
    for dir in std::env::args().skip(1) {
        let corpus = Corpus::open(std::path::Path::new(&dir)).unwrap();
        for (name, split) in [("train", Split::Train), ("validation", Split::Validation)] {
            for tree in corpus.trees(split) {
                let tree = tree.unwrap().tree;
                let tip = tree.nodes().iter().map(|n| n.thickness).fold(f32::INFINITY, f32::min);
                let _ = tip;
                let tip = if tree.info.species == "walnut" { 0.02 } else { 0.01 };
                let s = TreeTraits::of(&tree).state(tip_count(tree.root().thickness, tip));
                let s: Vec<String> = s.iter().map(|x| format!("{x:.5}")).collect();
                println!(
                    "{},{name},{},{},{}",
                    tree.info.species,
                    tree.info.age,
                    tree.info.gravitropism,
                    s.join(",")
                );
            }
        }
    }
}

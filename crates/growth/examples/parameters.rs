//! Prints the parameter table as Markdown.

fn main() {
    print!("{}", deeptree_growth::parameters::markdown());
}

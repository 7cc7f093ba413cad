//! `phiz-fit`: the offline program.
fn main() {}

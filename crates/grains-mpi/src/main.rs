//! `mpirun -n 2 grains-mpi case.toml`: a distributed discrete-element solver for granular flow.

fn main() {
    grains_program::main();
}

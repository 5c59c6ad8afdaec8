//! Bindings of the PETSc functions this crate uses, from the installed headers.

use std::env;
use std::path::PathBuf;

const HEADER: &str = "#include <petscksp.h>\n#include <petscdmda.h>\n";

const FUNCTIONS: [&str; 65] = [
    "PetscInitialize",
    "PetscInitialized",
    "PetscFinalize",
    "PetscPopSignalHandler",
    "PetscPushErrorHandler",
    "PetscErrorMessage",
    "PetscError",
    "PetscGetVersionNumber",
    "PetscOptionsSetValue",
    "PetscOptionsGetInt",
    "PCMGGetGalerkin",
    "PetscOptionsUsed",
    "DMDACreate3d",
    "DMDAGetCorners",
    "DMSetUp",
    "DMDestroy",
    "DMCreateGlobalVector",
    "MatCreateSeqAIJ",
    "MatSeqAIJSetPreallocationCSR",
    "MatSeqAIJGetArray",
    "MatSeqAIJRestoreArray",
    "MatCreateMPIAIJWithArrays",
    "MatUpdateMPIAIJWithArray",
    "MatCreateVecs",
    "MatMult",
    "MatMultTranspose",
    "MatSetOption",
    "MatSetNullSpace",
    "MatNullSpaceCreate",
    "MatNullSpaceDestroy",
    "MatDestroy",
    "KSPCreate",
    "KSPSetType",
    "KSPSetTolerances",
    "KSPGetTolerances",
    "KSPSetNormType",
    "KSPSetOptionsPrefix",
    "KSPSetFromOptions",
    "KSPSetOperators",
    "KSPSetInitialGuessNonzero",
    "KSPSetReusePreconditioner",
    "KSPGetPC",
    "KSPSetUp",
    "KSPSolve",
    "KSPGetIterationNumber",
    "KSPGetResidualNorm",
    "KSPGetConvergedReason",
    "KSPDestroy",
    "PCSetType",
    "PCGetType",
    "PCMGSetLevels",
    "PCMGSetInterpolation",
    "PCMGGetSmoother",
    "PCSORSetOmega",
    "PCRedundantGetKSP",
    "PCShellSetContext",
    "PCShellGetContext",
    "PCShellSetApply",
    "PCShellSetName",
    "VecGetLocalSize",
    "VecGetArray(Read)?",
    "VecRestoreArray(Read)?",
    "Vec(Place|Reset)Array",
    "Vec(Norm|Sum|Shift|Set)",
    "VecDestroy",
];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let petsc = pkg_config::probe_library("petsc")
        .or_else(|_| pkg_config::probe_library("PETSc"))
        .unwrap_or_else(|e| panic!("PETSc is missing (Debian: apt-get install petsc-dev): {e}"));
    let mpi = pkg_config::Config::new()
        .cargo_metadata(false)
        .probe("mpi")
        .unwrap_or_else(|e| panic!("MPI is missing (Debian: apt-get install libopenmpi-dev): {e}"));
    let includes = petsc.include_paths.iter().chain(&mpi.include_paths);
    let mut builder = bindgen::Builder::default()
        .header_contents("petsc.h", HEADER)
        .clang_args(includes.map(|path| format!("-I{}", path.display())))
        .blocklist_type("MPI_Comm|ompi_.*")
        .raw_line("pub use mpi_sys::MPI_Comm;")
        .default_enum_style(bindgen::EnumVariation::ModuleConsts)
        .layout_tests(false)
        .generate_comments(false)
        .allowlist_var("PETSC_(COMM_WORLD|DECIDE|DETERMINE|DEFAULT)");
    for function in FUNCTIONS {
        builder = builder.allowlist_function(function);
    }
    let bindings = builder.generate().unwrap_or_else(|e| panic!("bindings of PETSc: {e}"));
    let target = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR")).join("petsc.rs");
    bindings.write_to_file(&target).unwrap_or_else(|e| panic!("{}: {e}", target.display()));
}

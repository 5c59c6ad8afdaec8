# SPDX-License-Identifier: (Apache-2.0 OR MIT)

import os

from spack_repo.builtin.build_systems.cargo import CargoPackage

from spack.package import *


class GrainsMpi(CargoPackage):
    """Granular and particulate flow on many processors: particles of any shape, with a fluid among or around
    them, heat and reactions."""

    homepage = "https://github.com/grains-mpi/grains-mpi"
    git = "https://github.com/grains-mpi/grains-mpi.git"

    license("Apache-2.0 OR MIT")

    version("main", branch="main")

    variant("native", default=False, description="Compile for the processor of the machine that builds")
    variant("completions", default=True, description="Install the completions of bash, zsh and fish")

    depends_on("c", type="build")
    depends_on("rust@1.89:", type="build")
    depends_on("pkgconfig", type="build")
    # bindgen reads the headers of MPI, HDF5 and PETSc with libclang.
    depends_on("llvm+clang", type="build")
    depends_on("openmpi@4.1:")
    depends_on("hdf5@1.10.8:+mpi")
    depends_on("petsc@3.18:~complex+double~int64+mpi")

    build_directory = "crates/grains-mpi"
    build_args = ["--locked"]

    def setup_build_environment(self, env: EnvironmentModifications) -> None:
        env.set("LIBCLANG_PATH", self.spec["llvm"].prefix.lib)
        env.set("HDF5_DIR", self.spec["hdf5"].prefix)
        env.set("MPICC", self.spec["mpi"].mpicc)
        # Debian calls the description of Open MPI for pkg-config `mpi`, Open MPI itself `ompi`.
        env.prepend_path("PKG_CONFIG_PATH", os.path.join(self.stage.path, "pkgconfig"))
        libraries = [self.spec[name].prefix.lib for name in ("hdf5", "petsc", "openmpi")]
        flags = [f"-C link-arg=-Wl,-rpath,{folder}" for folder in libraries]
        if self.spec.satisfies("+native"):
            flags.append("-C target-cpu=native")
        env.set("RUSTFLAGS", " ".join(flags))

    @run_before("build")
    def describe_mpi(self):
        folder = os.path.join(self.stage.path, "pkgconfig")
        mkdirp(folder)
        with open(os.path.join(folder, "mpi.pc"), "w", encoding="utf-8") as file:
            file.write("Name: mpi\nDescription: MPI\nVersion: 3.1\nRequires: ompi\n")

    @run_after("install")
    def install_manual(self):
        program = Executable(self.prefix.bin.join("grains-mpi"))
        texts = {("man",): join_path(self.prefix.share.man.man1, "grains-mpi.1")}
        if self.spec.satisfies("+completions"):
            texts["completions", "bash"] = bash_completion_path(self.prefix) / "grains-mpi"
            texts["completions", "zsh"] = zsh_completion_path(self.prefix) / "_grains-mpi"
            texts["completions", "fish"] = fish_completion_path(self.prefix) / "grains-mpi.fish"
        for arguments, path in texts.items():
            mkdirp(os.path.dirname(path))
            with open(path, "w", encoding="utf-8") as file:
                program(*arguments, output=file)

    def check(self):
        """The tests start ranks and take long: the contact laws against their closed forms are enough here."""
        Executable(self.prefix.bin.join("grains-mpi"))("verify")

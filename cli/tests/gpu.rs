//! `flb bake --backend gpu`. Needs an adapter; lavapipe (`scripts/setup test` installs it) will do.

use crate::flb::{Folder, PAPER, SMALL};

mod flb;

#[test]
fn the_gpu_bakes_what_the_cpu_does() {
    let folder = Folder::with_plants(&["shrub"]);
    let bake = |out: &str, more: &[&str]| {
        let words = ["bake", "shrub.glb", "-o", out, "--threshold", "0"];
        let words = [&words[..], &PAPER, &SMALL, more].concat();
        folder.flb(&words).expect_code(0)
    };
    bake("cpu.flb", &[]);
    let run = bake("gpu.flb", &["--backend", "gpu", "--json"]).says(&["flb: solving on "]);
    assert_eq!(run.json()["converged"], true);
    // Of the largest value of each array, and of other bits than the CPU's.
    folder.flb(&["diff", "cpu.flb", "gpu.flb", "--tolerance", "1e-3"]).expect_code(0);
    folder.flb(&["diff", "cpu.flb", "gpu.flb"]).expect_code(1);
    let recorded = b"\"solve.solver\":\"gpu\"";
    assert!(folder.read("gpu.flb").windows(recorded.len()).any(|bytes| bytes == recorded));

    bake("again.flb", &["--backend", "gpu", "--threads", "1"]);
    assert!(folder.read("again.flb") == folder.read("gpu.flb"), "two runs on one GPU differ");
}

#[test]
fn a_bake_without_a_gpu_says_what_to_install_and_writes_nothing() {
    let folder = Folder::with_plants(&["leaf-card"]);
    let nothing = [("WGPU_BACKEND", "vulkan"), ("VK_DRIVER_FILES", "/none"), ("VK_ICD_FILENAMES", "/none")];
    let words = ["bake", "leaf-card.glb", "-o", "x.flb", "--backend", "gpu"];
    let run = folder.flb_in(&nothing, &[&words[..], &PAPER].concat());
    run.expect_code(5).says(&["no GPU", "VULKAN", "apt-get install mesa-vulkan-drivers"]);
    assert_eq!(folder.names(), ["leaf-card.glb"]);
}

#[test]
fn a_solver_of_the_cpu_on_the_gpu_is_refused() {
    let folder = Folder::with_plants(&["leaf-card"]);
    for solver in ["sweep", "explicit", "literal"] {
        let words = ["bake", "leaf-card.glb", "-o", "x.flb", "--backend", "gpu", "--solver", solver];
        folder.flb_with(&words, &PAPER).expect_code(2).says(&["--solver", "--backend gpu"]);
    }
}

//! Other compilers than naga take the shaders of volumes: GLSL and HLSL to SPIR-V that is valid.

use std::path::Path;
use std::process::Command;

use flb_runtime::light::volume_words::{GLSL, HLSL};

/// A pixel shader that asks for the light of a plant.
const ASKS: &str = "
float4 shade(float3 point_m : TEXCOORD0) : SV_Target0 { return float4(flb_light(0u, 3u, point_m), 1.0); }
";

/// Runs one of the commands that `scripts/setup test` installs.
fn run(name: &str, arguments: &[&str], folder: &Path) {
    let mut command = Command::new(name);
    let done = command.args(arguments).current_dir(folder).output();
    let done = done.unwrap_or_else(|error| panic!("{name}: {error}; scripts/setup test installs it"));
    let told = String::from_utf8_lossy(&done.stdout);
    assert!(done.status.success(), "{name} {arguments:?}: {told}{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn the_shaders_of_volumes_compile_to_spir_v_from_glsl_and_from_hlsl() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let folder = folder.path();
    std::fs::write(folder.join("volume.glsl"), GLSL).expect("a file");
    std::fs::write(folder.join("volume.hlsl"), HLSL.to_owned() + ASKS).expect("a file");
    run("glslangValidator", &["-V", "-S", "frag", "-o", "glsl.spv", "volume.glsl"], folder);
    run(
        "glslangValidator",
        &["-D", "-V", "-S", "frag", "-e", "shade", "-o", "hlsl.spv", "volume.hlsl"],
        folder,
    );
    ["glsl.spv", "hlsl.spv"].into_iter().for_each(|module| run("spirv-val", &[module], folder));
}

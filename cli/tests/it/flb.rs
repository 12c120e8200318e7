//! The built `flb` command in a folder of its own.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, OnceLock};

use serde_json::Value;

/// A temporary folder that `flb` runs in; gone when dropped.
pub(crate) struct Folder(tempfile::TempDir);

/// What a run said and how it ended.
pub(crate) struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

/// Flags of a bake that takes about a second.
pub(crate) const SMALL: [&str; 4] = ["--lattice", "32", "--voxels", "256"];

/// The papers' model; the other is the default.
pub(crate) const PAPER: [&str; 2] = ["--model", "paper"];

/// The default model with the fewest directions: a solve takes a quarter of the time.
pub(crate) const FEW: [&str; 2] = ["--ordinates", "18"];

/// Flags that choose each of the models, for what must hold with both.
pub(crate) const MODELS: [&[&str]; 2] = [&FEW, &PAPER];

/// What several tests begin with, made for the first of them.
fn made_once(what: String, make: impl FnOnce() -> Vec<u8>) -> Vec<u8> {
    static MADE: Mutex<BTreeMap<String, Arc<OnceLock<Vec<u8>>>>> = Mutex::new(BTreeMap::new());
    let cell = Arc::clone(MADE.lock().expect("nothing panics in between").entry(what).or_default());
    cell.get_or_init(make).clone()
}

impl Folder {
    pub(crate) fn new() -> Folder {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    /// With `PLANT.glb` of 2,000 triangles (a leaf card has 2) for each plant.
    pub(crate) fn with_plants(plants: &[&str]) -> Folder {
        let folder = Folder::new();
        for plant in plants {
            let grown = made_once(format!("grow {plant}"), || {
                let (folder, mesh) = (Folder::new(), format!("{plant}.glb"));
                let triangles = if *plant == "leaf-card" { "2" } else { "2000" };
                folder.flb(&["grow", plant, "--triangles", triangles, "-o", &mesh]).expect_code(0);
                folder.read(&mesh)
            });
            folder.write(&format!("{plant}.glb"), grown);
        }
        folder
    }

    /// The same with `PLANT.flb`, baked with these flags, which ends with one of these codes.
    pub(crate) fn with_baked(plants: &[&str], flags: &[&str], codes: &[i32]) -> Folder {
        let folder = Folder::with_plants(plants);
        for plant in plants {
            let baked = made_once(format!("bake {plant} {flags:?}"), || {
                let folder = Folder::with_plants(&[plant]);
                let [mesh, file] = ["glb", "flb"].map(|extension| format!("{plant}.{extension}"));
                let run = folder.flb_with(&["bake", &mesh, "-o", &file], flags);
                assert!(codes.contains(&run.code), "{}: {}", run.code, run.stderr);
                folder.read(&file)
            });
            folder.write(&format!("{plant}.flb"), baked);
        }
        folder
    }

    /// With the leaf card baked at lattice 16 into `card.flb`, with the papers' model: the quickest file there is.
    pub(crate) fn with_card() -> Folder {
        Folder::with_card_of(&PAPER)
    }

    /// The same with flags of a model.
    pub(crate) fn with_card_of(model: &[&str]) -> Folder {
        let flags = [&["--lattice", "16", "--voxels", "128"], model].concat();
        let folder = Folder::with_baked(&["leaf-card"], &flags, &[0]);
        fs::rename(folder.path("leaf-card.flb"), folder.path("card.flb")).expect("both are in the folder");
        folder
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> &Folder {
        fs::write(self.path(name), bytes).expect("a temporary file");
        self
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Names of everything in it, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        names_in(self.0.path())
    }

    /// Runs `flb` in the folder.
    pub(crate) fn flb(&self, words: &[&str]) -> Run {
        self.flb_in(&[], words)
    }

    /// The same with these environment variables.
    pub(crate) fn flb_in(&self, environment: &[(&str, &str)], words: &[&str]) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_flb"));
        self.run(command.args(words).envs(environment.iter().copied()))
    }

    /// As [`Folder::flb_in`], without waiting for its end.
    pub(crate) fn start(&self, environment: &[(&str, &str)], words: &[&str]) -> Child {
        let mut command = Command::new(env!("CARGO_BIN_EXE_flb"));
        command.args(words).envs(environment.iter().copied()).current_dir(self.0.path());
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the command starts")
    }

    /// As [`Folder::flb`], with limits that the system enforces: words of the shell's `ulimit`.
    #[cfg(unix)]
    pub(crate) fn flb_under(&self, limits: &[String], words: &[&str]) -> Run {
        self.run(&mut self.under(limits, words))
    }

    /// As [`Folder::flb_under`]; `None` where a signal ends it.
    #[cfg(unix)]
    pub(crate) fn try_under(&self, limits: &[String], words: &[&str]) -> Option<Run> {
        let output = self.under(limits, words).output().expect("the command starts");
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        let (stdout, stderr) = (text(output.stdout), text(output.stderr));
        output.status.code().map(|code| Run { code, stdout, stderr })
    }

    #[cfg(unix)]
    fn under(&self, limits: &[String], words: &[&str]) -> Command {
        let limits: String = limits.iter().map(|limit| format!("ulimit {limit} && ")).collect();
        let script = format!("{limits}exec \"$0\" \"$@\"");
        let mut shell = Command::new("sh");
        shell.args(["-c", &script, env!("CARGO_BIN_EXE_flb")]).args(words).current_dir(self.0.path());
        shell
    }

    fn run(&self, command: &mut Command) -> Run {
        let output = command.current_dir(self.0.path()).output().expect("the command starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("output is UTF-8");
        let (stdout, stderr) = (text(output.stdout), text(output.stderr));
        let ended = || panic!("{command:?}: {}: {stderr}", output.status);
        Run { code: output.status.code().unwrap_or_else(ended), stdout, stderr }
    }

    /// As [`Folder::flb`], several lists of words joined.
    pub(crate) fn flb_with(&self, words: &[&str], more: &[&str]) -> Run {
        self.flb(&[words, more].concat())
    }
}

/// Names of everything in a folder, sorted.
pub(crate) fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("the folder can be listed");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

impl Run {
    #[track_caller]
    pub(crate) fn expect_code(self, code: i32) -> Run {
        assert_eq!(self.code, code, "stdout: {}\nstderr: {}", self.stdout, self.stderr);
        self
    }

    /// stderr holds all of `parts`.
    #[track_caller]
    pub(crate) fn says(self, parts: &[&str]) -> Run {
        for part in parts {
            assert!(self.stderr.contains(part), "{part:?} is not in stderr: {}", self.stderr);
        }
        self
    }

    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {}", self.stdout))
    }
}

/// A program of scripts/tools.txt, as scripts/setup installs it.
pub(crate) fn python(module: &str, words: &[&str]) -> Command {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or("target".into(), PathBuf::from);
    let packages = root.join(target).join("tools/python");
    assert!(packages.is_dir(), "{}: scripts/setup test installs it", packages.display());
    let mut command = Command::new("/usr/bin/python3");
    command.args(["-m", module]).args(words).env("PYTHONPATH", packages);
    command
}

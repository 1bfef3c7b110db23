"""The command robocon: help, exit codes, and what each command does to a student's folder."""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import typer
from typer.testing import CliRunner

from conftest import ROOT
from robocon_course import cli, desk, doctor, files
from robocon_course.exercises import registry
from robocon_course.exercises.workspace import Workspace
from robocon_course.simulator import match

LESSONS = [f"{about.name}.ipynb" for about in registry.chapters()]
COMMANDS = typer.main.get_command(cli.app).commands
SOLVED = ROOT / "solutions" / "00_start.ipynb"
UNTOUCHED = ROOT / "notebooks" / "00_start.ipynb"
DRIVE = ROOT / "data" / "imu" / "drive.csv"


def robocon(*arguments) -> tuple[int, str]:
    """Exit code and output of one command, white space evened out."""
    done = CliRunner().invoke(cli.app, [str(a) for a in arguments], env={"COLUMNS": "200"})
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, " ".join((done.output + done.stderr).split())


@pytest.fixture(autouse=True)
def elsewhere(tmp_path, monkeypatch) -> Path:
    """An empty folder outside the checkout to type commands in."""
    monkeypatch.delenv("ROBOCON_WORKSPACE", raising=False)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def started(monkeypatch) -> list[list[str]]:
    """Commands that would have been started."""
    commands: list[list[str]] = []

    def run(command, **_):
        commands.append(command)
        return SimpleNamespace(returncode=0, stdout=b"")

    monkeypatch.setattr(cli.course.subprocess, "run", run)
    return commands


# --- help and exit codes ----------------------------------------------------------------------


def test_the_commands_are_those_that_the_course_promises():
    promised = {"lab", "doctor", "build", "check", "grade", "reset", "status"}
    promised |= {"attitude", "drive"}
    assert promised <= set(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_says_what_a_command_does_and_what_each_option_means(name):
    code, said = robocon(name, "--help")
    assert code == 0 and len(said) > 200
    words = " ".join(said.replace("│", " ").split())  # the frame around a text that takes two lines
    for parameter in COMMANDS[name].params:
        if parameter.name != "help":
            assert parameter.help and parameter.help in words, parameter.name


def test_help_lists_every_command_and_the_exit_codes():
    code, said = robocon("--help")
    assert code == 0 and all(name in said for name in COMMANDS)
    assert "Exit codes: 0 fine, 1 wrong answers or drift, 2 unusable input." in said


def test_without_a_command_the_help_is_shown():
    assert "Usage" in robocon()[1]


def test_python_m_works_too():
    done = subprocess.run(
        [sys.executable, "-m", "robocon_course.cli", "--help"],
        capture_output=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0 and "robocon lab" in done.stdout.decode()


def test_a_pipe_without_our_signs_shows_a_question_mark():
    done = subprocess.run(
        [sys.executable, "-m", "robocon_course.cli", "check", str(UNTOUCHED)],
        capture_output=True,
        env=os.environ | {"PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "ascii"},
    )
    assert done.returncode == 1
    assert done.stdout.decode().startswith("? not attempted: start.wrap_angle")


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        (["nonsense"], "No such command"),
        (["check"], "Missing argument"),
        (["check", "nowhere.ipynb"], "there is no file nowhere.ipynb"),
        (["grade", "nowhere", "--csv", "x.csv"], "nowhere is not a folder"),
        (["grade", ".", "--csv", "x.csv"], "holds no notebook and no folder"),
        (["grade", "."], "Missing option"),
        (["reset"], "give a lesson (robocon reset 01) or a part"),
        (["reset", "01", "--part", "imu.mahony_step"], "give a lesson"),
        (["reset", "77"], "there is no chapter '77'"),
        (["reset", "00"], "holds no lessons; go to the folder with your notebooks"),
        (["status"], "holds no lessons; go to the folder with your notebooks"),
        (["attitude", "nowhere.csv"], "nowhere.csv"),
        (["build", "--check", "--only", "77"], "no lesson source 77"),
        (
            ["match", "--opponent", "mean"],
            "--opponent: expected one of weak, middling, strong, none",
        ),
        (["match", "--team", "green"], "team: expected one of red, blue, got 'green'"),
        (["match", "--strategy", "C"], "strategy: expected one of A, B, ahead, got 'C'"),
        (["match", "--sent", "-1"], "--sent: expected a number of balls, got -1"),
        (["match", "--record", __file__], "--record: expected a folder, "),
        (["season", "--seeds", "0"], "at least one match"),
        (["season", "--workers", "0"], "at least one process"),
        (["season", "--strategy", "C", "--seeds", "1"], "strategy: expected one of A, B, ahead"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_input_that_cannot_be_used_ends_with_2_and_a_sentence(arguments, sentence):
    code, said = robocon(*arguments)
    assert code == 2 and sentence in said
    assert "Traceback" not in said
    assert "Robot of student" not in said, "refused only after the simulator was compiled"


# --- lab --------------------------------------------------------------------------------------


def test_lab_in_a_checkout_opens_the_notebooks_there(started, monkeypatch):
    monkeypatch.chdir(ROOT / "tests")
    assert robocon("lab")[0] == 0
    [command] = started
    assert (
        command[:4]
        == [
            sys.executable,
            "-m",
            "jupyter",
            "lab",
        ]
        and f"--ServerApp.root_dir={ROOT / 'notebooks'}" in command
    )
    assert "--no-browser" not in command


def test_lab_elsewhere_makes_a_workspace_with_every_lesson(started, elsewhere):
    assert robocon("lab", "--no-browser")[0] == 0
    assert sorted(p.name for p in (elsewhere / "robocon").iterdir()) == LESSONS
    [command] = started
    assert f"--ServerApp.root_dir={elsewhere / 'robocon'}" in command
    assert "--LabApp.default_url=/lab/tree/00_start.ipynb" in command
    assert command[-1] == "--no-browser"


def test_lab_never_overwrites_and_fills_up_what_is_missing(started, elsewhere):
    (elsewhere / "mine").mkdir()
    (elsewhere / "mine" / "00_start.ipynb").write_text("my own work")
    for _ in range(2):
        assert robocon("lab", "mine")[0] == 0
    assert (elsewhere / "mine" / "00_start.ipynb").read_text() == "my own work"
    assert (elsewhere / "mine" / "01_imu.ipynb").read_bytes() == (
        files.lessons_folder() / "01_imu.ipynb"
    ).read_bytes()


def test_lab_hands_on_how_jupyter_ended(monkeypatch):
    monkeypatch.setattr(cli.course.subprocess, "run", lambda command: SimpleNamespace(returncode=3))
    assert robocon("lab")[0] == 3


# --- check and grade --------------------------------------------------------------------------


def test_check_says_each_verdict_and_ends_with_0_1_or_2(elsewhere):
    code, said = robocon("check", SOLVED)
    assert code == 0 and "✔ passed: start.wrap_angle, 1 of 1 points" in said
    assert "1 of 1 points, student number 0" in said
    code, said = robocon("check", UNTOUCHED)
    assert code == 1 and "– not attempted: start.wrap_angle" in said
    (elsewhere / "broken.ipynb").write_text("{")
    code, said = robocon("check", "broken.ipynb")
    assert code == 2 and "not a notebook of format 4" in said


def test_grade_writes_a_table_and_shows_it(elsewhere):
    (elsewhere / "in").mkdir()
    (elsewhere / "in" / "ann.ipynb").write_bytes(SOLVED.read_bytes())
    (elsewhere / "in" / "ben [bold].ipynb").write_text("{")
    code, said = robocon("grade", "in", "--csv", "points.csv", "--jobs", "2")
    assert code == 0 and "2 submissions, table in points.csv" in said
    assert "ann.ipynb 0 1 / 1" in said and "ben [bold].ipynb" in said
    with (elsewhere / "points.csv").open(newline="") as file:
        assert [row["points"] for row in csv.DictReader(file)] == ["1", "0"]


def test_grade_says_before_the_work_that_the_table_has_no_place(elsewhere):
    (elsewhere / "in").mkdir()
    (elsewhere / "in" / "ann.ipynb").write_text("{")
    code, said = robocon("grade", "in", "--csv", "nowhere/points.csv")
    assert code == 2 and "there is no folder" in said


# --- build ------------------------------------------------------------------------------------


def test_build_outside_a_checkout_says_so(monkeypatch, tmp_path):
    monkeypatch.setattr(files, "CHECKOUT", tmp_path)
    code, said = robocon("build")
    assert code == 2 and "build runs in a checkout" in said


def test_build_without_the_maintainers_packages_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "jupytext", None)
    code, said = robocon("build", "--check")
    assert code == 2 and 'pip install -e ".[instructor]"' in said


# --- reset and status -------------------------------------------------------------------------


@pytest.fixture
def room(elsewhere) -> Workspace:
    """A workspace with lessons and two versions of one part."""
    desk.prepare(elsewhere / "robocon")
    workspace = Workspace(elsewhere / "robocon")
    for answer in ("return 1", "return 2"):
        workspace.accept("imu.mahony_step", f"def mahony_step():\n    {answer}\n")
    workspace.remember(student=7, points={"imu.mahony_step": 4.0})
    return workspace


def test_reset_puts_a_pristine_lesson_in_place_and_keeps_the_old_ones(room):
    lesson = room.folder / "00_start.ipynb"
    for count, text in enumerate(["first try", "second try"], 1):
        lesson.write_text(text)
        code, said = robocon("reset", "00")
        assert code == 0 and f"kept as 00_start.kept-{count}.ipynb" in said
        assert lesson.read_bytes() == desk.pristine("00_start.ipynb")
    kept = [room.folder / f"00_start.kept-{count}.ipynb" for count in (1, 2)]
    assert [path.read_text() for path in kept] == ["first try", "second try"]
    assert json.loads(lesson.read_text(encoding="utf-8"))["nbformat"] == 4


def test_reset_of_a_lesson_that_is_not_there_brings_it(room, monkeypatch):
    monkeypatch.chdir(room.folder)
    (room.folder / "01_imu.ipynb").unlink()
    assert robocon("reset", "imu") == (0, "01_imu.ipynb is new again")


def test_reset_leaves_the_robot_alone(room):
    before = room.part("imu.mahony_step")()
    robocon("reset", "01")
    assert room.part("imu.mahony_step")() == before == 2


def test_reset_of_a_part_brings_back_the_version_before_or_the_one_named(room):
    code, said = robocon("reset", "--part", "imu.mahony_step")
    assert (code, said) == (0, "imu.mahony_step is version 1 of 2 again")
    assert room.part("imu.mahony_step")() == 1
    assert robocon("reset", "--part", "imu.mahony_step", "--version", "2")[0] == 0
    assert room.part("imu.mahony_step")() == 2


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        (["--part", "imu.mahony_step", "--version", "9"], "holds versions 1 to 2"),
        (["--part", "imu.mahony_step", "--version", "-1"], "holds versions 1 to 2"),
        (["--part", "imu.euler_angles"], "no accepted version"),
        (["--part", "../../etc"], "no accepted version"),
    ],
)
def test_reset_of_a_version_that_is_not_there_says_which_are(room, arguments, sentence):
    code, said = robocon("reset", *arguments)
    assert code == 2 and sentence in said


def test_status_shows_points_parts_and_what_comes_next(room, monkeypatch):
    code, said = robocon("status")
    assert code == 0
    assert "01 IMU: calibration and the Mahony filter: 4 of 21 points" in said
    assert "Parts of your robot: imu.mahony_step (version 2)" in said
    assert "Next: start.wrap_angle in 00_start.ipynb" in said
    monkeypatch.chdir(room.folder)
    assert robocon("status") == (0, said)


def test_a_workspace_named_in_the_environment_is_the_one_that_is_used(tmp_path, monkeypatch):
    monkeypatch.setenv("ROBOCON_WORKSPACE", str(tmp_path / "named"))
    Workspace(tmp_path / "named").remember(points={"start.wrap_angle": 1.0})
    assert "00 Start here: 1 of 1 points" in robocon("status")[1]


# --- doctor -----------------------------------------------------------------------------------

WELL = {name: "1.0" for name in doctor.CORE} | {"opencv-python-headless": "4.12.0"}
VISION = {
    "ultralytics-opencv-headless": "8.4",
    "torch": "2.13.0+cpu",
    "torchvision": "0.28.0",
    "onnx": "1.23",
}


@pytest.fixture
def installed(monkeypatch):
    """Pretend that these distributions are installed, and a kernel that is this Python."""

    def pretend(**changes) -> None:
        found = WELL | {name.replace("_", "-"): v for name, v in changes.items()}
        monkeypatch.setattr(doctor, "_version", found.get)
        monkeypatch.setattr(doctor, "_kernel", lambda: doctor.Line("kernel", True, "python3"))

    return pretend


def test_doctor_says_that_all_is_well(installed):
    installed()
    code, said = robocon("doctor")
    assert code == 0 and said.endswith("All is well. Open the course with: robocon lab")
    assert "✘" not in said and "training in chapter 06" in said


def test_doctor_is_content_with_a_matching_pair_for_vision(installed):
    installed(**VISION)
    assert robocon("doctor")[0] == 0


@pytest.mark.parametrize(
    "changes, cause, fix",
    [
        (
            {"opencv_python": "4.12.0"},
            "2 distributions of one module",
            "pip uninstall -y opencv-python opencv-python-headless && "
            "pip install --force-reinstall --no-deps opencv-python-headless",
        ),
        (
            {"opencv_python_headless": None},
            "cv2: not installed",
            "pip install --force-reinstall --no-deps opencv-python-headless",
        ),
        (
            VISION | {"torchvision": "0.27.1"},
            "torchvision 0.27.1, which was built for another torch",
            'pip install "torchvision~=0.28.0"',
        ),
        (VISION | {"torch": None}, "torch: not installed", 'pip install "torch~=2.13.0"'),
        ({"numba": None}, "numba: not installed", 'pip install "numba>=0.61"'),
    ],
)
def test_doctor_names_the_illness_and_the_exact_cure(installed, changes, cause, fix):
    installed(**changes)
    code, said = robocon("doctor")
    assert code == 1 and "✘" in said
    cure = fix.replace("pip ", f'"{sys.executable}" -m pip ')
    assert cause in said and f"Mend it with: {cure}" in said


def test_doctor_names_the_first_illness_and_counts_the_rest(installed):
    installed(numba=None, opencv_python="4.12.0")
    cure = f'"{sys.executable}" -m pip install "numba>=0.61"'
    assert f"numba: not installed. Mend it with: {cure} (1 more after that)" in doctor.summary()


def test_doctor_notices_a_missing_kernel_and_one_of_another_python(installed, monkeypatch):
    from jupyter_client import kernelspec

    real = doctor._kernel
    installed()
    monkeypatch.setattr(doctor, "_kernel", real)
    fix = f'"{sys.executable}" -m ipykernel install --sys-prefix --name python3'

    def none(self, name):
        raise kernelspec.NoSuchKernel(name)

    monkeypatch.setattr(kernelspec.KernelSpecManager, "get_kernel_spec", none)
    code, said = robocon("doctor")
    assert code == 1 and "kernel: no kernel python3 (NoSuchKernel)" in said and fix in said

    other = SimpleNamespace(argv=["/somewhere/else/python"])
    monkeypatch.setattr(kernelspec.KernelSpecManager, "get_kernel_spec", lambda s, n: other)
    code, said = robocon("doctor")
    assert code == 1 and "python3 runs /somewhere/else/python" in said and fix in said

    same = SimpleNamespace(argv=[sys.executable])
    monkeypatch.setattr(kernelspec.KernelSpecManager, "get_kernel_spec", lambda s, n: same)
    assert robocon("doctor")[0] == 0


# --- attitude ---------------------------------------------------------------------------------


def test_attitude_turns_a_recording_into_angles_and_a_picture(elsewhere):
    code, said = robocon("attitude", DRIVE, "--out", "results")
    assert code == 0 and "6000 samples" in said
    with (elsewhere / "results" / "drive_attitude.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6000 and {"roll_deg", "pitch_deg", "yaw_deg"} <= set(rows[0])
    picture = (elsewhere / "results" / "drive_attitude.png").read_bytes()
    assert picture.startswith(b"\x89PNG") and len(picture) > 5000


def test_attitude_takes_off_the_bias_of_the_time_at_rest_or_says_why_not(elsewhere):
    still = DRIVE.with_name("still.csv")
    code, said = robocon("attitude", still, "--still", "15", "--out", "results")
    assert code == 0 and "Gyro bias from 15 s at rest" in said
    code, said = robocon("attitude", DRIVE, "--still", "0.8", "--out", "results")
    assert code == 2 and "too few for a bias" in said
    code, said = robocon("attitude", DRIVE, "--still", "30", "--out", "results")
    assert code == 2 and "moved" in said


def test_attitude_listens_to_its_gains(elsewhere):
    ends = []
    for gain in ("0", "5"):
        assert robocon("attitude", DRIVE, "--kp", gain, "--out", f"kp{gain}")[0] == 0
        ends.append((elsewhere / f"kp{gain}" / "drive_attitude.csv").read_text())
    assert ends[0] != ends[1]


def test_attitude_refuses_a_file_without_the_columns(elsewhere):
    (elsewhere / "other.csv").write_text("a,b\n1,2\n3,4\n")
    code, said = robocon("attitude", "other.csv")
    assert code == 2 and "Traceback" not in said and len(said) > 20


# --- drive ------------------------------------------------------------------------------------


def test_drive_reaches_area_3_and_says_how_well(elsewhere):
    code, said = robocon("drive", "--goal", 4.3, 10.0, "--student", 3, "--gif", "drive.gif")
    assert code == 0, said
    assert "Robot of student 3, parts: reference" in said
    assert "✔ arrived, after" in said and "touched something 0 times" in said
    assert (elsewhere / "drive.gif").read_bytes().startswith(b"GIF8")


def test_drive_takes_the_parts_and_the_number_of_the_students_own_desk(room):
    room.remember(student=7)
    room.accept("geometry.wrap_angle", "def wrap_angle(angle):\n    return angle\n")
    half_speed = (
        "import numpy as np\ndef speed_profile(path, max_speed, max_accel, max_lateral_accel):\n"
        "    return np.r_[0.0, np.full(len(path) - 2, 0.4), 0.0]\n"
    )
    room.accept("tracking.speed_profile", half_speed)
    code, said = robocon("drive", "--goal", 0.6, 1.2)
    assert code == 0 and "Robot of student 7, parts: mixed, 3 of" in said
    assert float(re.search(r"([\d.]+) s by its speed profile", said)[1]) > 2.0
    code, said = robocon("drive", "--goal", 0.6, 1.2, "--parts", "reference")
    assert code == 0 and "Robot of student 7, parts: reference" in said


def test_drive_ends_with_1_where_the_robot_does_not_arrive(room):
    lame = "import numpy as np\ndef field_to_robot(twist, theta):\n    return np.zeros(3)\n"
    room.accept("swerve.field_to_robot", lame)
    code, said = robocon("drive", "--goal", 0.6, 0.9)
    assert code == 1 and "✘ stopped for being late" in said


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--goal", 3.0, 7.5), "goal: (3, 7.5) m lies in an obstacle"),
        (("--goal", "nan", 1.0), "goal: entry (0,) is not a finite number"),
        (("--kind", "perfect"), "kind: expected one of ideal, noisy, degraded, got 'perfect'"),
        (("--parts", "yours"), "which: expected 'mixed', 'mine' or 'reference', got 'yours'"),
        (("--parts", "mine"), "holds no lessons"),
        (("--gif", "nowhere/drive.gif"), "there is no folder"),
        (("--student", "-1"), "student: expected a number"),
    ],
)
def test_drive_refuses_what_it_cannot_do_with_a_sentence(arguments, sentence):
    code, said = robocon("drive", *arguments)
    assert code == 2 and sentence in said


# --- match and season -------------------------------------------------------------------------


@pytest.fixture
def short(monkeypatch):
    """Matches of 20 s: one ball, if all goes well."""
    monkeypatch.setattr("robocon_course.simulator.match.MATCH", 20.0)


def test_a_match_is_told_state_by_state_and_won_with_0(short):
    code, said = robocon("match", "--seed", "1", "--opponent", "none")
    assert code == 0 and "Robot of student" in said and "parts: reference, seed 1" in said
    assert "go_to_area_3 start" in said and "approach_silo silo chosen" in said
    assert "✔ won by points after 20.0 s" in said and "1 balls stored, 0 fouls" in said


@pytest.mark.parametrize("strategy", ["A", "B"])
def test_a_match_is_played_with_another_order(short, strategy):
    code, said = robocon("match", "--seed", "1", "--opponent", "none", "--strategy", strategy)
    assert code == 0 and "1 balls stored" in said


@pytest.mark.parametrize(("asked", "given"), [([], 12), (["--sent", "24"], 24)])
@pytest.mark.parametrize("command", [["match"], ["season", "--seeds", "1", "--workers", "1"]])
def test_how_many_balls_robot_1_sends_may_be_asked_for(short, monkeypatch, command, asked, given):
    sent, made = [], match.Others.__init__

    def watched(self, *arguments, **settings):
        sent.append(arguments[3])
        made(self, *arguments, **settings)

    monkeypatch.setattr(match.Others, "__init__", watched)
    assert robocon(*command, "--opponent", "none", *asked)[0] == 0
    assert sent == [given]


def test_a_match_that_is_not_won_ends_with_1(monkeypatch):
    monkeypatch.setattr("robocon_course.simulator.match.MATCH", 1.0)
    code, said = robocon("match", "--seed", "1")
    assert code == 1 and "– a draw by points after 1.0 s" in said


def test_a_season_is_a_table_with_a_row_for_each_match_and_their_sums(short):
    code, said = robocon("season", "--seeds", "2", "--first", "1", "--workers", "1")
    told = " ".join(said.replace("│", " ").split())  # a narrow terminal breaks the cells' lines
    assert code == 0 and "2 matches" in told and "won 2 of 2," in told and "Vang 0" in told
    assert re.search(r"1 │ won by points │ 20 s", said) and re.search(r"2 │ won by points", said)

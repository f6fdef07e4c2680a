"""Files with models of a user's own: found, loaded, built, and what goes wrong told by its line."""

import re
import sys
import threading
import types

import numpy as np
import pytest

from app.features.own_models.error_messages import OwnModelError, running
from app.features.own_models.guards import OwnMotion, OwnSensor
from app.features.own_models.model_file import ModelFile, build, load
from app.features.own_models.slot import Slot
from app.features.own_models.watch import FileWatch, ModelFolder, models_in
from robot.geometry import Pose2
from robot.scan import Scan
from robot.settings import SettingError

OFFERED = {"field": "a field", "parameters": 3, "edges": [1]}
SCAN = Scan(0.0, np.zeros(3), np.array([0.2, np.inf, 0.3]))


def loaded(wrap, path, name="Mine"):
    slot = Slot(wrap, Pose2())
    slot.choose(ModelFile(path, name))
    slot.make(OFFERED, fresh=True)
    return slot


SENSOR = "class Mine:\n    def log_likelihood(self, poses, scan):\n        {}\n"
MOTION = "class Mine:\n    def sample(self, poses, moved, rng):\n        {}\n"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("class Mine:\n    def log_likelihood(self, poses\n", "line 2: SyntaxError: .* was never"),
        ("import nowhere_at_all\n", "line 1: ModuleNotFoundError: No module named 'nowhere_at_all"),
        ("raise SystemExit('enough')\n", "line 1: SystemExit: enough"),
        ("x = 1\n", "there is no class Mine; it has none"),
        ("class Other:\n    pass\n", "there is no class Mine; it has Other"),
        ("class Mine:\n    pass\n", "Mine has no method log_likelihood"),
        ("\0", "SyntaxError|ValueError"),
        (SENSOR.format("return missing"), "line 3: NameError: name 'missing' is not defined"),
        (SENSOR.format("pass"), "line 2: log_likelihood gives None; is its `return` missing"),
        (SENSOR.format("return poses"), r"line 2: .* the shape \(2, 3\); valid is \(2,\)"),
        (SENSOR.format("return poses[:, 0] * float('nan')"), "line 2: .* gives nan for 2 of 2"),
        (SENSOR.format("return poses[:, 0] - float('inf')"), "line 2: .* gives -inf for 2 of 2"),
        (SENSOR.format("return 'high'"), "line 2: ValueError: could not convert string"),
        (SENSOR.format("return self.log_likelihood(poses, scan)"), "line 3: RecursionError"),
        (SENSOR.format("exit(3)"), "line 3: (NameError|SystemExit)"),
        (SENSOR.format("raise ValueError('x' * 9999)"), r"line 3: ValueError: x{200,290} \.\.\.$"),
    ],
)
def test_a_broken_sensor_model_is_told_with_its_line(save, text, told):
    slot = loaded(OwnSensor, save(text))
    assert re.search(f"^mine.py.*{told}", slot.fault), slot.fault
    # The filter's belief stays as it is.
    assert slot.model.log_likelihood(np.zeros((4, 3)), SCAN).tolist() == [0, 0, 0, 0]


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("return moved.z", "line 3: AttributeError"),
        ("return poses[:, :2]", r"line 2: .* the shape \(2, 2\); valid is \(2, 3\)"),
        ("return poses / 0 if len(poses) > 2 else poses", "line (2|3): .*"),
        ("return poses + 1e12", "line 2: sample gives 1000000000000.* for 6 of 6"),
    ],
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_broken_motion_model_is_told_with_its_line(save, body, told):
    slot = loaded(OwnMotion, save(MOTION.format(body)))
    moved = slot.model.sample(np.zeros((5, 3)), Pose2(0.1, 0, 0.2), np.random.default_rng(0))
    assert re.search(f"^mine.py {told}", slot.fault), slot.fault
    # The particles follow odometry.
    assert moved == pytest.approx(np.tile([0.1, 0, 0.2], (5, 1)))


def test_what_is_not_on_offer_is_refused_with_what_is(save):
    path = save("""
        class Asks:
            def __init__(self, laser):
                pass
            def log_likelihood(self, poses, scan):
                return poses[:, 0]
    """)
    assert (
        loaded(OwnSensor, path, "Asks").fault
        == "mine.py line 3: Asks asks for laser; on offer: edges, field, parameters"
    )


def test_the_innermost_line_of_the_users_file_is_told(save):
    path = save("""
        import numpy as np

        class Deep:
            def log_likelihood(self, poses, scan):
                return self.inner(poses)

            def inner(self, poses):
                return np.linalg.inv(poses)
    """)
    fault = loaded(OwnSensor, path, "Deep").fault
    assert fault.startswith("mine.py line 9: numpy.linalg.LinAlgError: ")


def test_the_files_are_only_read_not_run_to_find_models(save):
    path = save("""
        raise RuntimeError("run")
        class Base:
            def sample(self, poses, moved, rng): ...
        class Heir(Base):
            def log_likelihood(self, poses, scan): ...
        class Neither:
            def other(self): ...
    """)
    found = models_in(path)
    assert [model.name for model in found.sensors] == ["mine.py:Heir"]
    assert [model.name for model in found.motions] == ["mine.py:Base", "mine.py:Heir"]


# --- small parts -----------------------------------------------------------------------------


@pytest.mark.parametrize("text", ["", "mine.py", "mine:Flat", "mine.py:", "mine.py:a b", ":Flat"])
def test_a_text_that_names_no_model_is_refused(text):
    with pytest.raises(SettingError, match=r"valid is FILE\.py:CLASS"):
        ModelFile.find(text)


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(SettingError, match="there is no file"):
        ModelFile.find(f"{tmp_path}/none.py:Flat")


def test_a_file_counts_as_saved_once_it_rests(save):
    watch = FileWatch(save("a = 1"))
    assert not watch.saved()
    path = save("a = 12")
    assert not watch.saved()
    save("a = 123")
    assert not watch.saved()
    assert watch.saved()
    assert not watch.saved()
    path.unlink()
    assert not watch.saved()
    assert not watch.saved()
    save("a = 1234")
    assert not watch.saved()
    assert watch.saved()


def test_a_file_may_import_the_one_beside_it(save):
    save("WIDTH = 3.0", "beside_it.py")
    slot = loaded(
        OwnSensor,
        save("import beside_it\n" + SENSOR.format("return 0 * poses[:, 0] + beside_it.WIDTH")),
    )
    assert slot.fault is None
    assert slot.model.log_likelihood(np.zeros((2, 3)), SCAN).tolist() == [3, 3]


def test_with_the_model_the_files_beside_it_are_read_anew(save, tmp_path):
    (tmp_path / "parts").mkdir()
    save("", "parts/__init__.py")
    save("LENGTH = 10.0", "parts/inner.py")
    save("from parts.inner import LENGTH\nWIDTH = 3.0 + LENGTH", "beside_it.py")
    text = "import numpy\nimport beside_it\n" + SENSOR.format(
        "return 0 * poses[:, 0] + beside_it.WIDTH"
    )
    slot = loaded(OwnSensor, save(text))
    assert slot.model.log_likelihood(np.zeros((1, 3)), SCAN).tolist() == [13]
    save("LENGTH = 20.0", "parts/inner.py")
    slot.make(OFFERED, fresh=True)
    assert slot.model.log_likelihood(np.zeros((1, 3)), SCAN).tolist() == [23]
    # What is installed stays what everybody else has.
    assert sys.modules["numpy"] is np


def test_a_folder_has_its_own_files_though_another_has_them_by_the_same_name(save, tmp_path):
    text = "import beside_it\n" + SENSOR.format("return 0 * poses[:, 0] + beside_it.WIDTH")
    found = []
    for folder, width in (("one", 1.0), ("two", 2.0)):
        (tmp_path / folder).mkdir()
        save(f"WIDTH = {width}", f"{folder}/beside_it.py")
        slot = loaded(OwnSensor, save(text, f"{folder}/mine.py"))
        found += slot.model.log_likelihood(np.zeros((1, 3)), SCAN).tolist()
    assert found == [1, 2]


def test_what_the_program_has_imported_itself_is_not_read_anew(save, tmp_path, monkeypatch):
    known = types.ModuleType("known_before")
    known.__file__ = str(tmp_path / "known_before.py")
    monkeypatch.setitem(sys.modules, "known_before", known)
    path = save("import known_before\n" + SENSOR.format("return poses[:, 0]"))
    for _ in range(2):
        assert loaded(OwnSensor, path).fault is None
    assert sys.modules["known_before"] is known


def test_headings_come_back_within_half_a_turn(save):
    slot = loaded(OwnMotion, save(MOTION.format("return poses + 7.0")))
    moved = slot.model.sample(np.zeros((1, 3)), Pose2(), np.random.default_rng(0))
    assert moved[0] == pytest.approx([7, 7, 7 - 2 * np.pi])


def test_keyword_arguments_of_any_name_are_left_out(save):
    path = save("""
        class Mine:
            def __init__(self, *others, edges, scale=2, **more):
                self.told = (others, edges, scale, more)
    """)
    model = ModelFile(path, "Mine")
    assert build(model, load(model), OFFERED).told == ((), [1], 2, {})


def test_a_file_that_vanished_is_told(tmp_path):
    with pytest.raises(OwnModelError, match=r"none\.py: FileNotFoundError"):
        load(ModelFile(tmp_path / "none.py", "Mine"))


def test_hidden_files_and_those_of_other_kinds_are_not_looked_at(save, tmp_path):
    for name in ("_mine.py", ".mine.py", "mine.txt", "yours.py"):
        save(SENSOR.format("pass"), name)
    (tmp_path / "folder.py").mkdir()
    folder = ModelFolder(tmp_path)
    assert [model.name for model in folder.look().sensors] == ["yours.py:Mine"]
    save("class Mine: pass", "yours.py")
    assert folder.look().sensors == ()


def test_what_is_tried_out_is_not_the_model_that_is_used(save):
    path = save("""
        class Mine:
            def __init__(self):
                self.asked = 0
            def log_likelihood(self, poses, scan):
                self.asked += 1
                return [float(self.asked)] * len(poses)
    """)
    assert loaded(OwnSensor, path).model.log_likelihood(np.zeros((1, 3)), SCAN).tolist() == [1]


def test_where_a_model_hangs_is_found_from_another_thread(save):
    path = save("""
        class Mine:
            def __init__(self, field):
                entered, leave = field
                entered.set()
                leave.wait(20)
    """)
    entered, leave = threading.Event(), threading.Event()
    model = ModelFile(path, "Mine")
    thread = threading.Thread(target=build, args=(model, load(model), {"field": (entered, leave)}))
    thread.start()
    assert entered.wait(20)
    assert running(thread.ident) == "mine.py line 6: this does not end."
    leave.set()
    thread.join()
    assert running(thread.ident) is None
    assert running(None) is None

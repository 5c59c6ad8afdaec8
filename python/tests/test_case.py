"""Cases from dictionaries and files."""
import json

import numpy as np
import pytest

import grains


def test_a_case_of_a_dictionary_is_that_of_its_file(balls, tmp_path):
    case = grains.Case(balls)
    (tmp_path / "case.toml").write_text(case.to_toml())
    again = grains.Case.load(tmp_path / "case.toml")
    assert again.to_toml() == case.to_toml()
    assert case.content == json.loads(json.dumps(balls))


def test_numbers_of_numpy_are_numbers(balls):
    balls["gravity"] = np.array([0, 0, -9.81])
    balls["insert"][0]["count"] = np.int64(16)
    assert grains.Case(balls).content["insert"][0]["count"] == 16


@pytest.mark.parametrize("address, value, words", [
    ("time.ende", 1.0, ["time.ende", "end"]),
    ("material.glass.density", -1.0, ["material[0].density", "-1"]),
    ("contact.0.between", ["glass", "steel"], ["steel", "glass"]),
    ("wall.lid.kind", "plane", ["wall.lid", "box"]),
    ("gravity.z", 1.0, ["gravity"]),
])
def test_a_mistake_is_told_with_key_and_remedy(balls, address, value, words):
    with pytest.raises(grains.CaseError) as error:
        grains.Case(balls).changed({address: value})
    assert all(word in str(error.value) for word in words), error.value
    assert isinstance(error.value, ValueError)


def test_changes_leave_the_case_alone(balls):
    case = grains.Case(balls)
    other = case.changed({"time.end": 0.5, "insert.balls.count": 8, "output.particles": None, "limits.overlap": 0.2})
    assert case.content["time"]["end"] == 0.02
    assert other.content["time"]["end"] == 0.5 and other.content["insert"][0]["count"] == 8
    assert "particles" not in other.content["output"] and other.content["limits"]["overlap"] == 0.2


def test_check_tells_what_the_program_tells(balls):
    report = grains.Case(balls).check(ranks=2)
    assert report["particles"] == 16 and report["ranks"] == 2 and report["time_step"] == 4e-5
    assert report["memory"] > 1e7 and report["disk"] > 1e3 and report["time_step_reason"]


def test_a_missing_file_is_named():
    with pytest.raises(OSError, match="nothing.toml"):
        grains.Case.load("nothing.toml")


def test_the_schema_has_all_sections():
    assert {"domain", "time", "insert", "fluid"} <= set(grains.schema()["properties"])

"""Study files: every problem at once, each with its place."""

from textwrap import dedent

import jsonschema
import pytest
from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.study.factors import DRAW, EXPECTED
from desim_warehouse.study.file import study_schema
from desim_warehouse.study.reading import read_study

from .conftest import MULTIBOTS, ROOT


def problems(tmp_path, text):
    path = tmp_path / "study.yaml"
    path.write_text(dedent(text).replace("MODEL", str(MULTIBOTS)))
    with pytest.raises(dw.ModelError) as caught:
        read_study(path)
    return [line.replace(f"{tmp_path}/", "") for line in caught.value.problems]


BAD = {
    "unknown key": ("model: MODEL\nfactor: {fleet.size: 1..3}\n", "2:1: factor: unknown key, did you mean 'factors'?"),
    "no model": (
        "name: x\n",
        "1:1: model: missing, expected a model file, relative to the study file, or a whole model",
    ),
    "no such key of a model": (
        "model: MODEL\nfactors:\n  fleet.sise: [1, 2]\n",
        "3:3: factors.fleet.sise: no key of a model, did you mean 'fleet.size'?",
    ),
    "word for a list": (
        "model: MODEL\nfactors:\n  policies.charging: threshold\n",
        f"3:22: factors.policies.charging: should be {EXPECTED} (got 'threshold'); write [threshold]",
    ),
    "unknown form": (
        "model: MODEL\nfactors:\n  fleet.size: {rang: [1, 3]}\n",
        "3:16: factors.fleet.size.rang: unknown key, did you mean 'range'?",
    ),
    "backward range": (
        "model: MODEL\nfactors:\n  fleet.size: 6..1\n",
        "3:15: factors.fleet.size: an empty or endless range (got '6..1')",
    ),
    "empty list": ("model: MODEL\nfactors:\n  fleet.size: []\n", "3:15: factors.fleet.size: no values (got [])"),
    "a value twice": (
        "model: MODEL\nfactors:\n  fleet.size: [1, 2, 1]\n",
        "3:22: factors.fleet.size.2: given twice (got 1), expected once",
    ),
    "value out of range": (
        "model: MODEL\nfactors:\n  fleet.size: [1, 0]\n",
        "3:19: factors.fleet.size.1: should be greater than or equal to 1 (got 0)",
    ),
    "no such policy": (
        "model: MODEL\nfactors:\n  policies.charging:\n    - threshold\n    - treshold\n",
        "5:7: factors.policies.charging.1: ",
    ),
    "no such parameter": (
        "model: MODEL\nfactors:\n  policies.charging:\n    - threshold\n    - {name: threshold, lvl: 1}\n",
        "5:7: factors.policies.charging.1.lvl: unknown parameter of threshold",
    ),
    "parameter in set": (
        "model: MODEL\nset:\n  policies.charging: {name: threshold, lvl: 1}\n",
        "3:22: set.policies.charging.lvl: unknown parameter of threshold",
    ),
    "value in set": (
        "model: MODEL\nset: {fleet.size: 0}\n",
        "2:19: set.fleet.size: should be greater than or equal to 1 (got 0)",
    ),
    "draws in a grid": (
        "model: MODEL\nfactors:\n  fleet.size: {between: [1, 6]}\n",
        f"3:25: factors.fleet.size.between: no ranges to draw from since 0.4 (got [1, 6]), {DRAW}",
    ),
    "unequal pairs": (
        "model: MODEL\ndesign: paired\nfactors:\n  fleet.size: [1, 2]\n  battery.threshold: [2]\n",
        "2:9: design: lists of different lengths (fleet.size: 2, battery.threshold: 1)",
    ),
    "design": (
        "model: MODEL\ndesign: gird\n",
        "2:9: design: should be 'grid' or 'paired' (got 'gird'); did you mean 'grid'?",
    ),
    "a sampled design": (
        "model: MODEL\ndesign: {sobol: 64}\nfactors: {fleet.size: {between: [1, 6]}, battery.capacity: [8, 9]}\n",
        f"2:9: design: no sampled designs since 0.4 (got {{sobol: 64}}), {DRAW}",
    ),
    "a range with a dash": (
        "model: MODEL\nfactors:\n  fleet.size: 8-12\n",
        f"3:15: factors.fleet.size: should be {EXPECTED} (got '8-12'); write 8..12",
    ),
    "a range with a dash in a list": (
        "model: MODEL\nfactors:\n  fleet.size: [8-12]\n",
        "3:16: factors.fleet.size.0: should be a whole number (got '8-12'); write 8..12 for a range",
    ),
    "numbers for a section": (
        "model: MODEL\nfactors:\n  fleet: [2, 4]\n",
        "3:11: factors.fleet.0: should be a section with size and robot (got 2); vary a key in it, such as fleet.size",
    ),
    "keys of a form": (
        "model: MODEL\nfactors:\n  fleet.size: {range: [1, 6], step: 2}\n",
        f"3:15: factors.fleet.size: should be {EXPECTED} (got {{range: [1, 6], step: 2}})",
    ),
    "half a linspace": (
        "model: MODEL\nfactors:\n  fleet.size: {linspace: [1, 6]}\n",
        "3:26: factors.fleet.size.linspace: should have 3 entries, low, high and how many (at least 2), such as",
    ),
    "not a case": (
        "model: MODEL\nfactors:\n  demand: {cases: {low: 3}}\n",
        "3:25: factors.demand.cases.low: should be a section with names and what each stands for (got 3)",
    ),
    "a cap below the minimum": (
        "model: MODEL\nreplications: {indicator: T, half_width: 2 %, minimum: 20, cap: 9}\n",
        "2:65: replications.cap: below the minimum (got 9), expected at least 20",
    ),
    "an indicator that is a number": (
        "model: MODEL\nindicators: [T, 5]\n",
        "2:17: indicators.1: unknown indicator (got 5), expected one of T, S, C",
    ),
    "30 million replications": (
        "model: MODEL\nreplications: 30000000\n",
        "2:15: replications: too many (got 30000000), expected at most 100,000",
    ),
    "30 million runs": (
        "model: MODEL\nfactors: {battery.capacity: {linspace: [6, 9, 1000]}}\nreplications: 30000\n",
        "3:15: replications: too many runs (got 30,000,000), expected at most 1,000,000 runs in all",
    ),
    "30 million designs": (
        "model: MODEL\nfactors: {battery.capacity: {linspace: [6, 9, 30000]}, fleet.size: 1..1000}\n",
        "2:10: factors: more than 1,000,000 designs, expected fewer",
    ),
    "no replications": ("model: MODEL\nreplications: 0\n", "2:15: replications: should be greater than or equal to 1"),
    "half of a rule": (
        "model: MODEL\nreplications: {indicator: T}\n",
        "2:1: replications.half_width: missing, expected a number (a share of the mean, such as 2 % or 0.02)",
    ),
    "word in a rule": (
        "model: MODEL\nreplications: {indicator: T, half_width: 5, cpa: 3}\n",
        "2:42: replications.half_width: should be less than 1 (got 5)",
    ),
    "unknown indicator": (
        "model: MODEL\nindicators: [T, throughput]\n",
        "2:17: indicators.1: unknown indicator (got 'throughput'), did you mean 'throughput_per_hour'?",
    ),
    "baseline of no factor": (
        "model: MODEL\nfactors: {fleet.size: [1, 2]}\nbaseline: {fleet.sise: 1}\n",
        "3:11: baseline: 'fleet.sise' is no factor",
    ),
    "baseline of no design": (
        "model: MODEL\nfactors: {fleet.size: [1, 2]}\nbaseline: {fleet.size: 3}\n",
        "3:11: baseline: no design with fleet.size=3",
    ),
    "beyond the limits": ("model: MODEL\ntimeout: 1e300\n", "2:10: timeout: too large (got 1e+300), expected at most"),
    "seed": ("model: MODEL\nseed: -1\n", "2:7: seed: should be greater than or equal to 0 (got -1)"),
    "confidence": ("model: MODEL\nconfidence: 95\n", "2:13: confidence: should be less than 1 (got 95)"),
    "timeout": ("model: MODEL\ntimeout: 0\n", "2:10: timeout: should be greater than 0 (got 0)"),
    "name of a column": (
        "model: MODEL\nfactors:\n  seed: {cases: {a: {}}}\n",
        "3:3: factors.seed: the name of a column of its tables, expected another with cases",
    ),
    "name of an indicator": (
        "model: MODEL\nfactors:\n  T: {cases: {one: {fleet.size: 1}, two: {fleet.size: 2}}}\n",
        "3:3: factors.T: the name of an indicator, expected another with cases",
    ),
    "key of a case": (
        "model: MODEL\nfactors:\n  demand:\n    cases:\n      more: {tasks.good: [1]}\n",
        "5:14: factors.demand.cases.more.tasks.good: no key of a model, did you mean 'tasks.goods'?",
    ),
}


def test_a_sampled_design_is_one_mistake_whatever_its_factors(tmp_path):
    text, _ = BAD["a sampled design"]
    assert len(problems(tmp_path, text)) == 1


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_is_told_at_its_place(tmp_path, case):
    text, expected = BAD[case]
    messages = problems(tmp_path, text)
    assert any(line.startswith(f"study.yaml:{expected}") for line in messages), messages


def test_all_problems_are_told_at_once(tmp_path):
    messages = problems(tmp_path, "model: MODEL\nseed: x\nfactors:\n  fleet.size: 3..1\nset: {fleet.sise: 1}\n")
    assert len(messages) == 3
    text = "model: MODEL\ncap: 3\nfactors:\n  fleet.sise: [1]\n  fleet.size: 3..1\n  seed: [1]\nconfidence: 2\n"
    assert [line.split(": ")[1] for line in problems(tmp_path, text)] == [
        "cap",
        "factors.fleet.sise",
        "factors.fleet.size",
        "factors.seed",
        "confidence",
    ]


def test_a_combination_that_is_no_model_is_told_as_a_design(tmp_path):
    messages = problems(
        tmp_path,
        """\
        model: MODEL
        factors:
          fleet.size: [1, 3]
          tasks.unload_at:
            named: {one: [M], two: [M, N]}
        """,
    )
    assert len(messages) == 2  # both fleets have a number of robots other than two
    assert all("unload_at" in line and line.startswith("study.yaml:5:") for line in messages)


def test_a_missing_model_file_is_told_with_its_path(tmp_path):
    assert "no such file, expected a model file" in problems(tmp_path, "model: nowhere.yaml\n")[0]


def test_a_missing_study_file_is_told_with_the_nearest():
    with pytest.raises(dw.ModelError, match=r"no such file, expected a study file; did you mean '.*paper.yaml'"):
        read_study(ROOT / "studies" / "papr.yaml")


@pytest.mark.parametrize("name", ["paper", "fleet_size", "charging", "demand", "congestion"])
def test_the_schema_for_editors_knows_the_studies_that_come_with_us(name):
    schema = study_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    content = YAML(typ="safe", pure=True).load((ROOT / "studies" / f"{name}.yaml").read_text())
    jsonschema.validate(content, schema)
    for wrong in ({"factor": {}}, {"seed": -1}, {"design": {"sobol": "x"}}, {"factors": {"fleet.size": {"rang": 3}}}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate({**content, **wrong}, schema)


@pytest.mark.parametrize("name", ["paper", "fleet_size", "charging", "demand", "congestion"])
def test_the_studies_that_come_with_us_can_be_read(name):
    plan = read_study(ROOT / "studies" / f"{name}.yaml")
    assert len(plan.points()) >= 6
    assert plan.base.log == "tasks"


def test_studies_log_what_they_are_told_to():
    assert dw.Study(MULTIBOTS, changes={"log": "all"}).plan.base.log == "all"


def test_problems_of_arguments_are_told_by_key():
    with pytest.raises(dw.ModelError, match=r"study: factors\.fleet\.size\.1: should be greater than or equal to 1"):
        dw.Study(MULTIBOTS, {"fleet.size": [1, 0]})

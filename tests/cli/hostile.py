"""Hundreds of inputs that cannot be worked with, as calls of `desim`: what is asked of it, and the files for it.

Each function writes the files it needs to a folder and gives calls by name.
"""

import json
import os
from itertools import product
from pathlib import Path

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "models"
MULTIBOTS, TUTORIAL = str(MODELS / "multibots.yaml"), str(MODELS / "tutorial.yaml")
HALF = "\ud800"
"""Half of a surrogate pair: no character, and as a byte of an argument not UTF-8."""
LONG = "x" * 5000


def numbers(_):
    """Numbers that are none, or that nothing in a warehouse can have."""
    keys = (
        "fleet.size",
        "fleet.robot.radius",
        "fleet.robot.speed",
        "fleet.robot.margin",
        "fleet.first_exit_time",
        "fleet.start_energy",
        "tasks.load_time",
        "tasks.unload_time",
        "tasks.clear_time",
        "battery.capacity",
        "battery.threshold",
        "battery.consumption",
        "battery.charge_rate",
        "battery.reserve",
        "traffic.node_time",
        "traffic.collision_angle",
        "policies.interval",
        "run.length",
        "run.warm_up",
        "units.seconds",
        "layout.blocks.goods_size",
        "layout.blocks.aisle_width",
        "layout.blocks.columns",
    )
    values = ("-1e300", ".nan", "-.inf", "1e309", "9" * 500, "[1]", "{a: 1}", "0x", f'"{LONG}"')
    return {f"{key}={value[:9]}": ["run", MULTIBOTS, "--set", f"{key}={value}"] for key, value in product(keys, values)}


def overrides(_):
    """Overrides, one by one."""
    sets = (
        "fleet.size=1e20",
        "fleet.size=10000000",
        "fleet.size=0",
        "fleet.size=1.5",
        "fleet.size=true",
        "fleet.kinds={a: {count: 10000000}}",
        "fleet.kinds={a: {count: 3, speed: 1e-320}}",
        "fleet.robot.speed=5e-324",
        "fleet.robot.radius=1e200",
        "battery.taper={start: 0.5, end_rate: 1e-17}",
        "battery.taper={start: 1, end_rate: 1}",
        "battery.charge_rate=1e-300",
        "tasks.load_time=1e308",
        "tasks.goods={random: 1e8}",
        "tasks.goods={random: 100000000}",
        "tasks.goods={poisson: 1e9}",
        "tasks.goods={poisson: 1e-320}",
        "tasks.goods={saturated: 100000000}",
        "tasks.goods=[-1]",
        "tasks.goods=[1e9]",
        "tasks.goods={random: 3, poisson: 3}",
        "tasks.unload_at=[]",
        "tasks.unload_at=[A, A, 7, .nan]",
        "tasks.popularity={weights: []}",
        "tasks.popularity={file: /dev/zero}",
        "tasks.popularity={file: .}",
        "layout.blocks.columns=1000000000",
        "layout.blocks.rows=99999",
        "layout.blocks.block_depth=1000000000",
        "layout.bays.charging.places=1000000000",
        "policies.charging=nearest",
        "policies.allocation=a\ufffdb.py:C",
        "policies.allocation=/dev/zero:C",
        "policies.allocation=/:C",
        "policies.allocation=/proc/self/mem:C",
        "policies.allocation=.:C",
        "policies.allocation=:C",
        "policies.allocation=x.py:",
        "policies.allocation=os:path",
        "policies.allocation=sys:exit",
        "policies.allocation=__main__:main",
        f"policies.allocation={LONG}",
        f"policies.allocation={LONG}.py:C",
        "policies.allocation={name: nearest, candidates: 1e400}",
        "policies.charging={name: threshold, level: .nan}",
        "accept=[NOTHING]",
        "accept=everything",
        "log=0",
        "run=5",
        "run.length=8 m",
        "fleet.robot.speed=3 h",
        "tasks.load_time=1 / 0",
        "tasks.load_time=-8 h",
        "tasks.load_time=nan h",
        "tasks.load_time=1e400 h",
        f"name={HALF}",
        f"{HALF}=1",
        f"{LONG}=1",
        "=1",
        ".=1",
        "fleet.=1",
        "fleet..size=1",
        "fleet.size.size=1",
        "fleet.size",
        "fleet.size=[",
        "fleet.size={",
        "fleet.size=*a",
        "fleet.size=!!python/none 1",
        "layout=null",
        "fleet=null",
        "layout.blocks=[]",
        "layout.bays.x.at=[A]",
        "layout.bays={}",
        f"fleet.size={'[' * 5000}",
        "fleet.start=[Z]",
        "fleet.start_energy={uniform: [1, 0]}",
        "fleet.start_energy=101 %",
        "traffic.gridlock=always",
        "cost.time=.nan",
        "cost={}x",
    )
    return {f"{place}: {text[:60]!a}": ["run", MULTIBOTS, "--set", text] for place, text in enumerate(sets)}


def models(folder):
    """Files that are no model, for `check` and `run`."""
    plain = Path(TUTORIAL).read_text(encoding="utf-8")
    written = {
        "empty": "",
        "blank": "\n \n",
        "comment": "# nothing\n",
        "word": "warehouse",
        "number": "7",
        "list": "[1, 2]",
        "tab": plain.replace("  size", "\tsize"),
        "control": plain + "\x07",
        "nul": plain + "\0",
        "bell_name": "a\x01: 1",
        "latin": plain.encode() + b"# \xe9\n",
        "utf16": plain.encode("utf-16"),
        "binary": bytes(range(256)) * 10,
        "half": plain.replace("name: tutorial", 'name: "\\ud800"'),
        "two": plain + "---\n" + plain,
        "twice": plain + plain,
        "python": "a: !!python/object/apply:os.system [ls]",
        "tag": plain + "x: !own 1",
        "itself": "a: &a [*a]",
        "merge": "a: &a {<<: *a}",
        "merge_list": "a: {<<: [1, 2]}",
        "alias": "a: *b",
        "lists": "a: " + "[" * 100_000,
        "maps": "a: " + "{b: " * 50_000,
        "quotes": 'a: "' + "x" * 100_000,
        "deep": "\n".join(" " * deep + "a:" for deep in range(2000)),
        "colon": "a: b: c",
        "dash": "- a\nb: 1",
        "keys": "\n".join(f"k{i}: 1" for i in range(8_000)),
        "long_key": "x" * 100_000 + ": 1",
        "long_line": "name: " + "x" * 5_000_000,
        "date": plain.replace("size: 3", "size: 2026-01-01"),
        "base60": plain.replace("size: 3", "size: 1:30:00"),
        "octal": plain.replace("size: 3", "size: 0o9"),
        "complex": "? [1, 2]\n: 3",
        "null_key": "~: 1",
        "bool_key": plain + "yes: 1\n",
        "many_nodes": "layout:\n  nodes: {" + ", ".join(f"n{i}: [{i}, 0]" for i in range(8_000)) + "}\n",
        "json_deep": json.dumps({"name": "x", "fleet": {"size": [[[[[]]]]]}}),
    }
    calls = {}
    for name, text in written.items():
        path = folder / f"{name}.yaml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode("utf-8"))
        calls[f"check {name}"] = ["check", str(path)]
    (folder / "loop.yaml").symlink_to("loop.yaml")
    with (folder / "large.yaml").open("wb") as large:
        large.truncate(1 << 36)
    others = ("/dev/zero", "/dev/null", "/proc/self/mem", ".", "loop.yaml", "large.yaml", "", LONG, HALF)
    return {**calls, **{f"run {name[:20]!a}": ["run", str(name)] for name in others}}


def tables(folder):
    """CSV files of a layout, of popularity and of goods that cannot be read, or hold what cannot be."""
    model = (
        "layout:\n  nodes: {A: [0, 0], B: [20, 0], C: [20, 20]}\n  edges: [[A, B], [B, C], [C, A]]\n"
        "  storage: {file: FILE}\n  bays: {home: {at: [A]}}\nfleet: {size: 1, robot: {radius: 0.5, speed: 1}}\n"
        "tasks: {goods: [0], unload_at: [C], load_time: 1, unload_time: 1}\n"
    )
    written = {
        "empty": "",
        "head": "from,to,offset\n",
        "no_head": "A,B,1\n",
        "wrong_head": "a,b,c\nA,B,1\n",
        "word": "from,to,offset\nA,B,far\n",
        "nan": "from,to,offset\nA,B,nan\n",
        "inf": "from,to,offset\nA,B,1e999\n",
        "negative": "from,to,offset\nA,B,-1\n",
        "beyond": "from,to,offset\nA,B,21\n",
        "node": "from,to,offset\nA,Z,1\n",
        "edge": "from,to,offset\nB,A,1\n",
        "short": "from,to,offset\nA,B\n",
        "wide": "from,to,offset\nA,B,1,2,3\n",
        "quote": 'from,to,offset\n"A,B,1\n',
        "nul": "from,to,offset\nA\0,B,1\n",
        "utf16": "from,to\n".encode("utf-16"),
        "latin": b"from,to,offset\n\xe9,B,1\n",
        "cell": "from,to,offset\n" + "A" * 200_000 + ",B,1\n",
        "columns": ",".join(f"c{i}" for i in range(100_000)) + "\n",
        "binary": os.urandom(2000),
        "twice": "from,from,to,offset\nA,A,B,1\n",
        "digits": "from,to,offset\nA,B," + "9" * 5000 + "\n",
        "rows": "from,to,offset\n" + "A,Z,1\n" * 50_000,
    }
    calls = {}
    os.mkfifo(folder / "fifo.csv")
    with (folder / "large.csv").open("wb") as large:
        large.truncate(1 << 36)
    for name, content in written.items():
        (folder / f"{name}.csv").write_bytes(content if isinstance(content, bytes) else content.encode())
    names = {**{name: f"{name}.csv" for name in written}, "zero": "/dev/zero", "fifo": "fifo.csv", "large": "large.csv"}
    names |= {"none": "no.csv", "folder": ".", "itself": "of_itself.yaml", "long": LONG, "number": "7", "list": "[a]"}
    for name, file in names.items():
        path = folder / f"of_{name}.yaml"
        path.write_text(model.replace("FILE", file), encoding="utf-8")
        calls[f"storage {name}"] = ["run", str(path)]
    for name in ("zero", "fifo", "large", "word", "nul", "cell"):
        calls[f"popularity {name}"] = ["run", TUTORIAL, "--set", f"tasks.popularity={{file: {names[name]}}}"]
    return calls


def studies(folder):
    """Study files that would never end, or are none."""
    model = f"model: {TUTORIAL}\n"
    written = {
        "empty": "",
        "list": "[1]",
        "no_model": "factors: {fleet.size: [1]}",
        "itself": "model: itself.yaml\n",
        "zero": "model: /dev/zero\n",
        "folder": "model: .\n",
        "number": "model: 7\n",
        "half": f'{model}name: "\\ud800"\n',
        "factor": model + "factors: 3\n",
        "factor_list": model + "factors: [a, b]\n",
        "unknown": model + "factors: {fleet.sise: [1]}\n",
        "nothing": model + "factors: {fleet.size: []}\n",
        "wide": model + "factors: {fleet.size: {from: 1, to: 1000000000}}\n",
        "levels": model + "factors: {fleet.size: 1..1000000000}\n",
        "grid": model
        + "factors: {fleet.size: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]"
        + "".join(
            f", {key}: [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]"
            for key in (
                "tasks.load_time",
                "tasks.unload_time",
                "tasks.clear_time",
                "battery.threshold",
                "fleet.exit_time",
                "policies.interval",
                "traffic.node_time",
            )
        )
        + "}\n",
        "runs": model + "factors: {fleet.size: [1, 2]}\nreplications: 30000000\n",
        "negative": model + "replications: -3\n",
        "half_run": model + "replications: 1.5\n",
        "until": model + "replications: {half_width: 1e-300, of: T}\n",
        "sobol": model + "factors: {fleet.size: {from: 1, to: 4}}\ndesign: {sobol: 1099511627776}\n",
        "spiral": model + "design: spiral\n",
        "paired": model + "design: paired\nfactors: {fleet.size: [1, 2], log: [all]}\n",
        "cases": model + "factors: {x: {cases: {a: {fleet.sise: 1}}}}\n",
        "case_list": model + "factors: {x: {cases: [1]}}\n",
        "base": model + "factors: {fleet.size: [1]}\nbaseline: {fleet.size: 2}\n",
        "confidence": model + "confidence: 95\n",
        "confidence_nan": model + "confidence: .nan\n",
        "seed": model + "seed: -1\n",
        "seed_huge": model + f"seed: {'9' * 900}\n",
        "timeout": model + "timeout: -1\n",
        "indicator": model + "indicators: [no]\n",
        "indicators": model + "indicators: 3\n",
        "set": model + "set: {fleet.sise: 1}\n",
        "set_list": model + "set: [a]\n",
        "zero_seed": model + "seed: 1e400\n",
        "aliases": "a: &a [*a]\n",
        "deep": "factors: " + "[" * 100_000,
        "twice": model + model,
        "value_nan": model + "factors: {tasks.load_time: [.nan]}\n",
        "same": model + "factors: {replication: [1]}\n",
        "named": model + "factors: {fleet.size: {named: 3}}\n",
        "python": "model: !!python/object/apply:os.abort []\n",
    }
    calls = {}
    for name, text in written.items():
        path = folder / f"{name}.yaml"
        path.write_text(text, encoding="utf-8")
        calls[name] = ["study", str(path)]
    return calls


def options(folder):
    """Options of the command line."""
    (folder / "file").write_text("")
    (folder / "shut").mkdir()
    (folder / "loop").symlink_to("loop")
    vary = ["what-if", MULTIBOTS, "--vary", "fleet.size=1,2"]
    best = ["best", MULTIBOTS, "--vary", "fleet.size=1,2", "--indicator", "T"]
    size = ["size", MULTIBOTS, "--target"]
    out = [
        LONG,
        f"{HALF}/a",
        "file/\udcff",
        "file",
        "file/run",
        "loop",
        "/dev/null",
        "/dev/null/x",
        "/proc/x",
        "a/" * 3000,
        "/sys/x",
    ]
    calls = [["run", MULTIBOTS, "--out", place] for place in out]
    calls += [[*vary, "--out", place] for place in out]
    calls += [["run", MULTIBOTS, "--seed", seed] for seed in ("-1", "x", "1e3", "1.5", HALF, "", "0x10")]
    calls += [[*vary, "--workers", some] for some in ("100000", "-1", "0", "1.5", "all", "nan", HALF, "9" * 400)]
    calls += [[*vary, "--replications", some] for some in ("30000000", "-1", "0", "1e9", "nan", "{", HALF, "9" * 400)]
    calls += [[*vary, "--design", some] for some in ("spiral", "{sobol: 1e9}", "{sobol: -2}", "[")]
    calls += [[*vary, "--timeout", some] for some in ("-1", "nan", "x")]
    calls += [[*vary, "--confidence", some] for some in ("0", "1", "95", "nan", "-1")]
    calls += [
        [*vary, "--vary", some]
        for some in (
            "fleet.size=0..1000000000",
            "fleet.size=1..0",
            "fleet.size=",
            "fleet.size",
            "=1",
            "fleet.sise=1",
            "fleet.size=1..x",
            "tasks.load_time=1..inf",
            "tasks.load_time=0..1..1e-300",
            "fleet=1,2",
            f"{HALF}=1,2",
            "fleet.size=8-12",
            "fleet.size=[[[",
            "tasks.goods={random: 1e8},{random: 3}",
        )
    ]
    calls += [[*vary, "--indicator", some] for some in ("no", HALF, LONG, "")]
    calls += [[*vary, "--until", "T", "--half-width", some] for some in ("0", "-1", "nan", "x", "200 %")]
    calls += [[*best, "--delta", some] for some in ("1e-300", "0", "-1", "nan", "x", "1e-10")]
    calls += [[*best, "--delta", "5", "--first", some] for some in ("1", "30000000", "x")]
    calls += [[*best, "--delta", "5", "--cap", some] for some in ("1", "30000000", "-5")]
    calls += [
        [*size, some, "--range", "1..3"]
        for some in (
            "T",
            "T <",
            "T <= x",
            "T <= nan",
            "T == 3",
            "no >= 3",
            "on_time >= 95",
            "on_time >= 101 %",
            "T <= 5 %",
            HALF,
            "",
        )
    ]
    calls += [
        [*size, "T <= 9", "--range", some] for some in ("", "3..1", "0..2", "1..1000000000", "x", "{", "1,1", HALF)
    ]
    calls += [
        ["warm-up", MULTIBOTS],
        ["warm-up", TUTORIAL, "--observations", "0"],
        ["schema", "x"],
        ["policies", "--doc", HALF],
    ]
    for command in ("export", "replay", "report", "compare"):
        extra = {"export": ["--format", "csv"], "compare": ["--indicator", "T"]}
        calls += [[command, place, *extra.get(command, [])] for place in (LONG, HALF, "/dev/null", "shut", "loop", "")]
    calls += [[HALF], [LONG], ["run"], ["run", MULTIBOTS, "--set"], ["run", MULTIBOTS, "--no"], ["check", "--accept"]]
    calls += [["check", TUTORIAL, "--accept", code] for code in ("NOTHING", "", HALF)]
    return {f"{place}: {' '.join(call)[-80:]!a}": call for place, call in enumerate(calls)}


METHODS = {
    "allocation": "assign(self, situation)",
    "charging": "levels(self, robot)",
    "routing": "route(self, origin, goal, roads)",
    "parking": "choose(self, robot, bays, travel)",
}


def policies(folder):
    """Policies of the user's own that answer what cannot be, or do not want to."""
    bodies = {
        "infinity": "return float('inf')",
        "nan": "return float('nan')",
        "pair": "return [(float('inf'), float('nan'))]",
        "none": "return None",
        "text": "return 'robot'",
        "half": "return '\\ud800'",
        "itself": "return self",
        "exit": "import sys; sys.exit(0)",
        "exit_text": "import sys; sys.exit('good-bye')",
        "quit": "raise SystemExit",
        "raise": "raise ValueError('\\ud800')",
        "base": "raise BaseException('out')",
        "assert": "assert False, self",
        "stop": "raise StopIteration",
        "close": "raise GeneratorExit",
        "simpy": "import simpy; raise simpy.Interrupt(0)",
        "deep": "return self.METHOD",
        "memory": "raise MemoryError",
        "class": "return Mine",
        "huge": "return [[10 ** 400] * 2]",
        "recursion": "return self.assign(situation)",
        "yield": "yield 1 / 0",
        "import": "import no_such_module",
        "odd": "return type('Odd', (), {'__repr__': lambda s: 1 / 0, '__iter__': lambda s: iter([s])})()",
    }
    calls = {}
    for (kind, method), (name, body) in product(METHODS.items(), bodies.items()):
        word = method.partition("(")[0]
        text = body.replace("METHOD", word).replace("self.assign(situation)", f"self.{method.replace('(self, ', '(')}")
        path = folder / f"{kind}_{name}.py"
        path.write_text(f"class Mine:\n    def {method}:\n        {text}\n", encoding="utf-8")
        calls[f"{kind} {name}"] = ["run", MULTIBOTS, "--set", f"policies.{kind}={path}:Mine"]
    modules = {
        "syntax": "class Mine(:",
        "exits": "import sys; sys.exit(3)",
        "raises": "raise RuntimeError('no')",
        "nul": "a\0b",
        "base": "raise BaseException",
        "no_class": "Mine = 3",
        "no_method": "class Mine: pass",
        "empty": "",
        "needs": "class Mine:\n    def __init__(self, a): pass\n    def assign(self, s): return []",
        "init": "class Mine:\n    def __init__(self): raise SystemExit\n    def assign(self, s): return []",
        "latin": b"# \xe9\nclass Mine: pass",
        "indent": "class Mine:\npass",
        "function": "def Mine(): return []",
        "nothing": "class Mine:\n    assign = None",
        "meta": "class M(type):\n    def __call__(c): 1 / 0\nclass Mine(metaclass=M): pass",
    }
    for name, text in modules.items():
        path = folder / f"module_{name}.py"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        calls[f"module {name}"] = ["run", MULTIBOTS, "--set", f"policies.allocation={path}:Mine"]
    calls["check none"] = ["check", MULTIBOTS, "--set", f"policies.allocation={folder / 'module_exits.py'}:Mine"]
    return calls


def folders(folder):
    """Folders of runs and studies with files that were damaged, or made by an attacker."""
    import desim_warehouse as dw

    run = dw.simulate(dw.load(TUTORIAL)).save(folder / "run")
    study = dw.Study(dw.load(TUTORIAL), {"fleet.size": [1, 2]}, replications=2).run(out=folder / "study")
    assert study.rows
    deep = "[" * 100_000
    calls = {}
    damages = {
        "empty": "",
        "deep": deep,
        "list": "[]",
        "word": '"x"',
        "object": "{}",
        "nan": '{"format": NaN}',
        "half": '{"format": "\\ud800"}',
        "cut": '{"format": 1, "se',
        "binary": b"\xff\xfe\0",
        "number": "9" * 6000,
    }
    for name, text in damages.items():
        place = _copy(run, folder / f"run_{name}")
        (place / "run.json").write_bytes(text if isinstance(text, bytes) else text.encode())
        calls[f"export {name}"] = ["export", str(place), "--format", "trace", "-o", str(folder / "trace.json")]
        place = _copy(folder / "study", folder / f"study_{name}")
        (place / "study.json").write_bytes(text if isinstance(text, bytes) else text.encode())
        calls[f"compare {name}"] = ["compare", str(place), "--indicator", "T"]
        place = _copy(run, folder / f"log_{name}")
        (place / "log.parquet").write_bytes(text if isinstance(text, bytes) else text.encode())
        calls[f"replay {name}"] = ["replay", str(place), "-o", str(folder / "page.html")]
    content = json.loads((run / "run.json").read_text(encoding="utf-8"))
    changes = {
        "format": {"format": 99},
        "model": {"model": 3},
        "model_none": {"model": {}},
        "log": {"log": None},
        "log_list": {"log": []},
        "tallies": {"log": {}},
        "no_format": {"format": None},
    }
    for name, change in changes.items():
        place = _copy(run, folder / f"changed_{name}")
        (place / "run.json").write_text(json.dumps({**content, **change}), encoding="utf-8")
        calls[f"changed {name}"] = ["export", str(place), "--format", "csv", "-o", str(folder / "csv")]
    return calls


def _copy(source, target):
    import shutil

    shutil.copytree(source, target)
    return target


GROUPS = (numbers, overrides, models, tables, studies, options, policies, folders)

"""Names that would be code, markup or a path somewhere: refused in one line, or harmless in everything that is written."""

# ruff: noqa: E501  (tables)

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections import Counter
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from click.testing import CliRunner

import symgen
from symgen.cli import cli
from symgen.errors import SceneError, SymgenError
from symgen.scene.builder import SceneBuilder
from symgen.scene.model import Output
from symgen.scene.names import RESERVED
from symgen.scene.outputs import function_name
from symgen.scene.request import request
from symgen.targets.c.read_back import strip_comments
from tools.mutations import NAMES

MORE = (
    "mass_matrix", "hostile_mass_matrix", "sine_cosine", "cosine", "cos_q", "sin_q0", "M", "t1", "q0", "i", "n", "I", "errno",
    "_Bool", "restrict", "lambda", "x'y", "a/*b*/c", "\\", "x\\", "$HOME", "`id`", "a;b", "a,b", "a=b", "^_^", "~", "%", "100%",
    "\\end{document}", "\\input{/etc/passwd}", "$x$", "&", "#1", "{", "}", "_", "a_b", "a b", "a-b", "a.b", "a:b", "A_b", "A B",
    "<script>alert(1)</script>", '"><img src=x onerror=alert(1)>', "</style></title></pre>", "javascript:alert(1)", "'; --",
    "double_", "a\u00a0b", "ａ", "𝐱", "Ω", "ß", "İ", "ı", "नमस्ते", "العربية", "Ａ", "٣", "*/ } void evil(void) { /*", "x" * 200,
)  # fmt: skip
EVERY = tuple(dict.fromkeys((*NAMES, *MORE)))
STRICT = ["-std=c99", "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wtrigraphs", "-Werror"]


def robot(folder: Path, names: list[str], title: str = "hostile") -> Path:
    """A URDF file in which every name is that of a link and of a joint; all links hang on the root."""
    inertial = '<inertial><origin xyz="0 0.5 0"/><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
    rows = [f'<robot name={quoteattr(title)}><link name="root"/>']
    for k, name in enumerate(names):
        text = quoteattr(name, {"\n": "&#10;", "\t": "&#9;", "\r": "&#13;"})
        ends = f'<parent link="root"/><child link={text}/><origin xyz="{k} 0 0"/><axis xyz="1 0 0"/>'
        rows.append(f"<link name={text}>{inertial}</link>")
        rows.append(f'<joint name={text} type="revolute">{ends}<dynamics damping="0.1"/></joint>')
    path = folder / "robot.urdf"
    path.write_bytes(("".join(rows) + "</robot>").encode("utf-8", "surrogatepass"))
    return path


def over(folder: Path, names: list[str]) -> symgen.Scene:
    """A scene over the robot in which the names are in parameters, outputs and frames too."""
    robot(folder, names)
    parameters = [
        f"{name}.{what}" for name in names for what in ("mass", "damping") if "*" not in name and "[" not in name
    ]
    lines = [
        "name: hostile", "model: robot.urdf", f"parameters: {json.dumps(parameters, ensure_ascii=False)}",
        f"outputs: {json.dumps(['mass_matrix', 'bias_force', *(f'frame_pose:{name}' for name in names)], ensure_ascii=False)}",
        "options: {batch: true, status: true}",
    ]  # fmt: skip
    path = folder / "hostile.scene.yaml"
    path.write_text("\n".join(lines), encoding="utf-8")
    return symgen.load(path)


def is_read(name: str, folder: Path) -> bool:
    try:
        symgen.load(robot(folder, [name]))
    except SymgenError as error:
        assert str(error).isprintable() and len(str(error)) < 400 and str(error).startswith("robot.urdf")
        return False
    return True


def accepted(folder: Path) -> list[str]:
    return [name for name in EVERY if name != "ground" and is_read(name, folder)]


def test_a_name_is_read_or_refused_in_one_line(tmp_path: Path) -> None:
    read = accepted(tmp_path)
    refused = [name for name in EVERY if name not in read]
    assert "*/" in read and "a b" in read and "名前" in read
    assert {"", " ", "a\nb", "\x1b[31m", "\u202e", "\u200b", "x" * 201, "x" * 10_000} <= set(refused)


def test_functions_of_different_names_are_different(tmp_path: Path) -> None:
    read = accepted(tmp_path)
    functions = Counter(function_name(f"frame_pose:{name}") for name in read)
    assert max(functions.values()) == 1
    assert all(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) and len(name) <= 200 for name in functions)


def compilers() -> list[str]:
    return [cc for cc in ("gcc", "clang") if shutil.which(cc)]


def check_c(folder: Path) -> None:
    """Every file compiles without a word, and nothing of a name is outside comments."""
    for path in sorted(folder.glob("*.[ch]")):
        text = path.read_text(encoding="utf-8")
        code = re.sub(r'^#include ["<][\w.]+[">]$|extern "C"', "", strip_comments(text), flags=re.MULTILINE)
        code = re.sub(r"^#define SYMGEN_.*$", "", code, flags=re.MULTILINE)  # symgen's own macros
        code = code.replace('#pragma GCC optimize("rename-registers")', "")
        code = code if path.name != "main.c" else re.sub(r'"(\\.|[^"\\\n])*"', "", code)
        assert code.isascii() and not re.search(r"[\"'`$@]|evil\(|alert\(|/passwd|\?\?|//", code), path.name
        assert "??" not in text and all(line.isprintable() for line in text.split("\n"))
        assert not any("\\" in comment for comment in re.findall(r"/\*.*?\*/", text, re.DOTALL))
    for cc in compilers():
        for path in sorted(folder.glob("*.c")):
            ran = subprocess.run([cc, *STRICT, path.name], cwd=folder, capture_output=True, text=True, check=False)
            assert (ran.returncode, ran.stderr) == (0, ""), f"{cc} {path.name}: {ran.stderr[:300]}"
    if shutil.which("g++"):
        header = next(folder.glob("*.h")).name
        command = [
            "g++",
            "-x",
            "c++",
            "-fsyntax-only",
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Werror",
            "-include",
            header,
            "-",
        ]
        ran = subprocess.run(command, cwd=folder, input="", capture_output=True, text=True, check=False)
        assert (ran.returncode, ran.stderr) == (0, "")


def check_names(names: list[str], folder: Path) -> None:
    scene = over(folder, names)
    artifact = symgen.generate(scene, folder / "out")
    check_c(folder / "out")
    cmake = (folder / "out" / "CMakeLists.txt").read_text()
    assert not re.search(r"evil|alert|passwd|\$\(|`|double_", cmake)
    assert [joint["name"] for joint in artifact.manifest["joints"]] == names
    assert len({row["name"] for row in artifact.manifest["functions"]}) == len(names) + 2
    assert all(
        path.parent == folder / "out" / "hostile.casadi"
        for path in (folder / "out").rglob("*.casadi")
        if path.is_file()
    )


def test_names_in_everything_that_is_generated(tmp_path: Path) -> None:
    names = [
        "*/",
        "a\\",
        "??/",
        '"',
        "$(id)",
        "%s%n",
        "名前",
        "日本",
        "a b",
        "a-b",
        "A B",
        "double",
        "q0",
        "*/ } void evil(void) { /*",
    ]
    check_names([*names, "x" * 200, "../../etc/passwd"], tmp_path)


@pytest.mark.slow
def test_every_name_in_everything_that_is_generated(tmp_path: Path) -> None:
    read = [name for name in accepted(tmp_path) if name != "root"]
    for start in range(0, len(read), 30):
        folder = tmp_path / str(start)
        folder.mkdir()
        check_names(read[start : start + 30], folder)


# -- names of scenes -----------------------------------------------------------------------------------------------

RISKY = [
    "class",
    "sine",
    "q",
    "p",
    "main",
    "math",
    "symgen_shim",
    "manifest",
    "CMakeLists",
    "__x",
    "_",
    "x__y",
    "E",
    "n" * 60,
]
SCENES = [
    *RISKY,
    *sorted(RESERVED)[::7],
    "cosine",
    "sine_cosine",
    "reduce_large",
    "casadi",
    "assert",
    "M",
    "mass_matrix",
    "i",
]


def pendulum(name: str, batch: bool = False) -> symgen.Scene:
    builder = (
        SceneBuilder(name)
        .body("rod", mass=1, com=(0, 0, "-0.5"))
        .joint("j", "revolute", "ground", "rod", axis=(0, 1, 0))
    )
    return builder.outputs("mass_matrix", "forward_dynamics").options(batch=batch).build()


def check_scene_name(name: str, folder: Path, batch: bool = False) -> bool:
    """False for a name that is refused, in one line."""
    try:
        artifact = symgen.generate(pendulum(name, batch), folder / "out")
    except SceneError as error:
        assert str(error).isprintable()
        assert not (folder / "out").exists()
        return False
    check_c(folder / "out")
    f = artifact.load(flags=["-O0"], cache=folder / "cache")
    assert f.mass_matrix([0.0])[0, 0] == 0.25
    return True


def test_a_few_names_of_scenes(tmp_path: Path) -> None:
    taken = {name: check_scene_name(name, tmp_path / name) for name in ("class", "symgen_shim", "main", "math")}
    assert taken == {"class": True, "symgen_shim": True, "main": False, "math": False}


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_names_of_scenes(name: str, tmp_path: Path) -> None:
    check_scene_name(name, tmp_path, name in RISKY)


@pytest.mark.parametrize("name", EVERY, ids=lambda name: ascii(name)[:20])
def test_a_scene_and_its_parts_take_identifiers_only(name: str) -> None:
    if re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]{0,59}", name):
        return

    def builder(body: str = "b", joint: str = "j") -> SceneBuilder:
        return SceneBuilder("x").body(body).joint(joint, "revolute", "ground", body, axis=(1, 0, 0))

    wrong: list[Callable[[], symgen.Scene]] = [
        lambda: pendulum(name),
        lambda: builder(body=name).build(),
        lambda: builder(joint=name).build(),
        lambda: builder().frame(name, "b").build(),
        lambda: builder().outputs(name).build(),
        lambda: builder().outputs(**{name: ["mass_matrix"]}).build(),
        lambda: builder().lock(**{name: 0}).build(),
    ]
    if not re.search(r"[*?\[]|b\.mass", name):  # a pattern, or the parameter that there is
        wrong.append(lambda: builder().parameters(name).build())
    for build in wrong:
        with pytest.raises(SceneError) as caught:
            build()
        assert str(caught.value).isprintable() and len(str(caught.value)) < 400


# -- what people read ----------------------------------------------------------------------------------------------

MARKUP = ["<script>alert(1)</script>", '"><img src=x onerror=alert(1)>', "</style></title></pre>", "\\input{/etc/passwd}", "a&b",
          "100%", "$x^2$", "#1{", "'; --", "{{x}}", "{% x %}", "]]>"]  # fmt: skip


class Page(HTMLParser):
    """Counts elements; collects what runs when the page is opened or clicked."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: Counter[str] = Counter()
        self.runs: list[tuple[str, str]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[tag] += 1
        self.runs += [(tag, key) for key, value in attrs if key.startswith("on") or "javascript:" in (value or "")]


def page(folder: Path, names: list[str], title: str) -> Page:
    from symgen.report import write_report
    from symgen.validation import validate

    folder.mkdir()
    scene = symgen.load(robot(folder, names, title))
    scene = request(scene, [Output("mass_matrix", ("mass_matrix",)), Output("bias_force", ("bias_force",))])
    write_report(folder / "page.html", scene, validate(scene, against=(), states=2))
    parsed = Page()
    parsed.feed((folder / "page.html").read_text(encoding="utf-8"))
    return parsed


@pytest.mark.slow
def test_markup_in_the_report(tmp_path: Path) -> None:
    """A robot with hostile names has the elements that one with plain names has."""
    pytest.importorskip("matplotlib")
    hostile = page(tmp_path / "hostile", MARKUP, "<b onclick=x>")
    plain = page(tmp_path / "plain", [f"link{k}" for k in range(len(MARKUP))], "plain")
    for tag in ("script", "img", "style", "title", "pre", "b", "svg", "table", "iframe", "link"):
        assert hostile.tags[tag] == plain.tags[tag], tag
    assert hostile.runs == plain.runs


def test_markup_in_equations(tmp_path: Path) -> None:
    path = str(robot(tmp_path, MARKUP))
    ran = CliRunner().invoke(cli, ["show", path, "--equations", "h", "--format", "latex", "--symbols", "joint"])
    assert ran.exit_code == 0, ran.output
    assert not re.search(r"\\input|\\end\{document|[%#$<>]|(?<!\\)_(?![{])", ran.output)
    symbols = re.findall(r"cos\\left\((.*?)\\right\)", ran.output)
    assert len(set(symbols)) == len(MARKUP), "one symbol for each joint"


def test_text_and_json_of_show(tmp_path: Path) -> None:
    path = str(robot(tmp_path, ["a\u0301" * 50, "*/", *MARKUP]))
    ran = CliRunner().invoke(cli, ["show", path])
    assert ran.exit_code == 0 and all(line.isprintable() for line in ran.output.split("\n"))
    ran = CliRunner().invoke(cli, ["show", path, "--json"])
    assert ran.exit_code == 0 and "*/" in json.dumps(json.loads(ran.output))

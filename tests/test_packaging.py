"""What a user installs is complete, and what a machine installs is pinned."""

import importlib.metadata
import re
import subprocess
import sys
import tomllib
from email.message import Message
from email.parser import Parser
from pathlib import Path
from zipfile import ZipFile

import pytest
from packaging.requirements import Requirement

import fledge

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
VERSION = PROJECT["project"]["version"]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> ZipFile:
    out = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(out)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (path,) = out.glob("*.whl")
    return ZipFile(path)


@pytest.fixture(scope="module")
def metadata(wheel: ZipFile) -> Message:
    return Parser().parsestr(wheel.read(f"fledge-{VERSION}.dist-info/METADATA").decode())


def pins() -> dict[str, str]:
    """Package -> version, of the lock."""
    return dict(re.findall(r"^([\w.-]+)==([^\s;]+)", (ROOT / "requirements.lock").read_text(), re.MULTILINE))


def test_wheel_holds_every_file_of_the_package(wheel: ZipFile) -> None:
    source = {
        str(path.relative_to(ROOT / "src"))
        for path in (ROOT / "src" / "fledge").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert "fledge/py.typed" in source
    assert {name for name in wheel.namelist() if name.startswith("fledge/")} == source


def test_wheel_says_its_licence_and_its_command(wheel: ZipFile, metadata: Message) -> None:
    assert metadata["License-Expression"] == "Apache-2.0"
    info = f"fledge-{VERSION}.dist-info"
    assert "Apache License" in wheel.read(f"{info}/licenses/LICENSE").decode()
    assert "fledge = fledge.cli:main" in wheel.read(f"{info}/entry_points.txt").decode()


def test_wheel_says_what_it_needs(metadata: Message) -> None:
    needs = {Requirement(need) for need in metadata.get_all("Requires-Dist", [])}
    extras = PROJECT["project"]["optional-dependencies"]
    optional = [f'{need}; extra == "{name}"' for name, some in extras.items() for need in some]
    assert needs == {Requirement(need) for need in (*PROJECT["project"]["dependencies"], *optional)}


def test_versions_agree() -> None:
    newest = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    cited = re.search(r"^version: (\S+)", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert newest and cited
    assert {newest[1], cited[1], importlib.metadata.version("fledge")} == {VERSION}


def test_lock_names_no_address() -> None:
    assert not re.findall(
        r"^.*(?:\w+://|--(?:extra-)?index|--find-links).*$", (ROOT / "requirements.lock").read_text(), re.M
    )


def test_lock_pins_every_dependency_within_its_bounds() -> None:
    locked = pins()
    for need in PROJECT["project"]["dependencies"] + PROJECT["dependency-groups"]["dev"]:
        requirement = Requirement(need)
        assert locked.get(requirement.name) in requirement.specifier, need


def test_lock_hashes_every_pin() -> None:
    blocks = re.split(r"^(?=[\w.-]+==)", (ROOT / "requirements.lock").read_text(), flags=re.MULTILINE)[1:]
    assert len(blocks) == len(pins())
    assert all("--hash=sha256:" in block for block in blocks)


def test_every_dependency_is_bounded_on_both_sides() -> None:
    for need in PROJECT["project"]["dependencies"]:
        operators = {specifier.operator for specifier in Requirement(need).specifier}
        assert operators == {">=", "<"}, need


def test_every_public_name_can_be_imported() -> None:
    for name in getattr(fledge, "__all__", ()):
        assert getattr(fledge, name) is not None, name

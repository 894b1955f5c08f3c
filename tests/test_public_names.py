"""The face of the package: what is public, that it is there, and that documentation uses nothing else."""

import re
from pathlib import Path

import pytest

import ffgym
from scripts.tables.package_pages import find_packages

ROOT = Path(__file__).parent.parent
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


@pytest.mark.parametrize("package", list(find_packages()), ids=lambda package: package.__name__)
def test_no_public_name_is_that_of_a_module_beside_it(package):
    folder = Path(package.__file__).parent
    modules = {path.stem for path in folder.iterdir() if path.suffix == ".py" or path.is_dir()}
    assert not modules & set(package.__all__)


def test_the_package_offers_about_45_names_of_which_each_is_public_in_a_room():
    assert 40 <= len(ffgym.__all__) <= 55
    packages = {
        id(getattr(package, name)) for package in find_packages() if package is not ffgym for name in package.__all__
    }
    for name in ffgym.__all__:
        assert id(getattr(ffgym, name)) in packages, name


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_documents_import_from_the_package_or_one_level_below(document):
    imports = re.findall(
        r"^[ >]*(?:from|import) (ffgym[\w.]*)",
        document.read_text(encoding="utf-8"),
        flags=re.M,
    )
    assert not [name for name in imports if name.count(".") > 1]

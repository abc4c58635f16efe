"""Reading files from untrusted sources."""

from __future__ import annotations

import codecs
import os
from pathlib import Path

import pytest

from bt_controller.errors import TreeError
from bt_controller.loading.source import MAX_BYTES, MAX_LETTERS, MAX_NODES, read
from hmrsim.safe_xml import MAX_DEPTH


def test_elements_know_file_line_tag_and_name(files):
    path = files.write('<root>\n  <BehaviorTree ID="A">\n\n    <Say\n name="hello"/></BehaviorTree></root>')

    origin = read(path)[0][0].origin
    assert ("tree.xml", 4, "Say", "hello") == (origin.file, origin.line, origin.tag, origin.name)
    assert origin.says("no") == "tree.xml:4: <Say> 'hello': no"


@pytest.mark.parametrize(
    ("text", "error"),
    [
        (b"", r"^tree\.xml:1: is not valid XML: no element found$"),
        (b"hello", r"^tree\.xml:1: is not valid XML: syntax error$"),
        (b"<root>\n<a></root>", r"^tree\.xml:2: is not valid XML: mismatched tag$"),
        (b"<root/><root/>", "junk after document element"),
        (b"<root>\xff\xfe\xfa</root>", "not well-formed"),
        (b'<?xml version="1.0" encoding="klingon"?><root/>', "not valid XML: unknown encoding"),
        (b'<?xml version="1.0" encoding="shift_jis"?><root/>', r"not valid XML: "),
        (b"<root>&lol;</root>", "undefined entity"),
        (b'<!DOCTYPE r [<!ENTITY a "b">]>\n<root>&a;</root>', r"^tree\.xml:1: has a DOCTYPE"),
        (b'<!DOCTYPE r SYSTEM "file:///etc/passwd"><root/>', "has a DOCTYPE"),
        (b"<a>" * (MAX_DEPTH + 1), "is nested deeper than 100"),
        (b"<root>" + b"<a/>" * MAX_NODES, "has more than 10000 elements"),
        (b"<root a='" + b"x" * (MAX_LETTERS + 1) + b"'/>", "has a text of more than 10000 characters"),
        (b"<" + b"x" * (MAX_LETTERS + 1) + b"/>", "has a text of more than 10000 characters"),
        (b"<root>" + b" " * MAX_BYTES, "larger than 1048576 bytes, with all included files"),
    ],
)
def test_a_file_without_trees_is_refused_in_one_line(files, text, error):
    (files.folder / "tree.xml").write_bytes(text)

    with pytest.raises(TreeError, match=error) as caught:
        read("tree.xml")
    assert len(str(caught.value).splitlines()) == 1


def test_entities_that_blow_up_are_refused_at_once(files):
    lines = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10 if i else "lol"}">' for i in range(10))
    files.write(f"<!DOCTYPE lolz [{lines}]><root>&l9;</root>")

    with pytest.raises(TreeError, match="DOCTYPE"):
        read("tree.xml")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
def test_encodings_that_a_file_names_are_read(files, encoding):
    text = f'<?xml version="1.0" encoding="{codecs.lookup(encoding).name}"?><root><Say name="Küche"/></root>'
    (files.folder / "tree.xml").write_bytes(text.encode(encoding))

    assert read("tree.xml")[0].origin.name == "Küche"


def test_a_missing_file_is_one_line():
    with pytest.raises(TreeError, match=r"^nowhere\.xml: no such file$"):
        read("nowhere.xml")


def test_a_path_through_a_loop_of_links_is_one_line(files):
    (files.folder / "loop").symlink_to("loop")

    with pytest.raises(TreeError, match=r"^loop/tree\.xml: no such file$"):
        read("loop/tree.xml")


class TestInclude:
    """Elements such as <include path="…"/> insert the trees of another file."""

    def test_a_file_that_has_changed_is_read_again(self, files):
        main = '<include path="sub/b.xml"/><BehaviorTree ID="A"><SubTree ID="B"/></BehaviorTree>'
        files.write('<BehaviorTree ID="B"><Say name="one"/></BehaviorTree>', "sub/b.xml")
        first, again = files.load(main, tree="A"), files.load(main, tree="A")
        files.write('<BehaviorTree ID="B"><Say name="two"/></BehaviorTree>', "sub/b.xml")
        changed = files.load(main, tree="A")

        assert first is again
        assert ["one", "two"] == [found.blueprint.children[0].name for found in (first, changed)]

    @pytest.mark.parametrize("form", ['include path="sub/b.xml"', 'Import src="sub/b.xml"', 'Include file="sub/b.xml"'])
    def test_trees_come_from_the_included_file(self, files, form):
        files.write('<include path="c.xml"/><BehaviorTree ID="B"><Say/></BehaviorTree>', "sub/b.xml")
        files.write('\n<BehaviorTree ID="C"><Say/></BehaviorTree>', "sub/c.xml")
        files.write(f'<root><{form}/><BehaviorTree ID="A"><Say/></BehaviorTree></root>')

        found = read("tree.xml")
        assert ["C", "B", "A"] == [tree.attrib["ID"] for tree in found]
        assert ["sub/c.xml:2", "sub/b.xml:1", "tree.xml:1"] == [str(tree.origin) for tree in found]

    def test_what_is_included_twice_is_read_once(self, files):
        files.write('<BehaviorTree ID="C"><Say/></BehaviorTree>', "c.xml")
        files.write('<include path="c.xml"/>', "b.xml")

        assert len(read(files.write('<include path="b.xml"/><include path="c.xml"/>'))) == 1

    @pytest.mark.parametrize(
        ("text", "error"),
        [
            ('<include path="/etc/passwd"/>', r"^tree\.xml:1: <include>: '/etc/passwd' is outside the folder"),
            ('<include path="../x.xml"/>', "'../x.xml' is outside the folder of 'tree.xml'"),
            ('<include path="x.xml"/>', "'x.xml': no such file"),
            ('<include path="."/>', "'.': not a regular file"),
            ('<include path="a&#10;b"/>', 'needs path="…", relative to this file'),
            ("<include/>", 'needs path="…", relative to this file'),
            ('<include ros_pkg="nav2" path="x.xml"/>', "ROS packages are not supported; give a path"),
            ('<include path="tree.xml"/>', "'tree.xml' includes itself"),
        ],
    )
    def test_what_cannot_be_included_is_refused(self, files, text, error):
        files.write(text)

        with pytest.raises(TreeError, match=error):
            read("tree.xml")

    def test_a_link_does_not_lead_out_of_the_folder(self, files, tmp_path_factory):
        elsewhere = tmp_path_factory.mktemp("elsewhere") / "secret.xml"
        elsewhere.write_text("<root/>")
        (files.folder / "link.xml").symlink_to(elsewhere)
        files.write('<include path="link.xml"/>')

        with pytest.raises(TreeError, match=r"'link\.xml' is outside the folder"):
            read("tree.xml")

    def test_all_files_together_count(self, files):
        for number in range(3):
            files.write(f"<root>{' ' * (MAX_BYTES // 2)}</root>", f"{number}.xml")
        files.write("".join(f'<include path="{number}.xml"/>' for number in range(3)))

        with pytest.raises(TreeError, match=r"^1\.xml: larger than 1048576 bytes, with all included files"):
            read("tree.xml")

    def test_a_chain_of_files_has_an_end(self, files):
        for number in range(30):
            files.write(f'<include path="{number + 1}.xml"/>', f"{number}.xml")

        with pytest.raises(TreeError, match=r"19\.xml:1: <include>: includes are nested more than 20 deep"):
            read("0.xml")

    def test_errors_in_several_files_are_reported_at_once(self, files):
        files.write("<root>", "b.xml")
        files.write('<include path="c.xml"/>', "a.xml")
        files.write("".join(f'<include path="{name}.xml"/>' for name in ("a", "b", "b", "x")))

        with pytest.raises(TreeError) as caught:
            read("tree.xml")
        assert [
            "a.xml:1: <include>: 'c.xml': no such file",
            "b.xml:1: is not valid XML: no element found",
            "tree.xml:1: <include>: 'x.xml': no such file",
        ] == str(caught.value).splitlines()


@pytest.mark.parametrize("make", [Path.mkdir, os.mkfifo, lambda path: path.symlink_to("/dev/zero")])
def test_a_file_that_is_not_regular_is_not_opened(tmp_path, make):
    """A pipe would keep the reader waiting, and a device never ends."""
    path = tmp_path / "tree.xml"
    make(path)

    with pytest.raises(TreeError, match=r"tree\.xml: not a regular file$"):
        read(str(path))

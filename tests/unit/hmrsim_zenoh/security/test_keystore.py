"""Keystores: created files, their modes, and rejected changes."""

from __future__ import annotations

import fcntl
import json
import os
import stat
from contextlib import contextmanager
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.x509.oid import ExtendedKeyUsageOID

from hmrsim_zenoh.errors import BadOptions
from hmrsim_zenoh.security.keystore import Keystore, Network
from hmrsim_zenoh.wire.enclave import SIMULATOR, Member, find_enclave
from tests.cases import case
from tests.unit.hmrsim_zenoh.security.conftest import MEMBERS


def certificate(keystore, name):
    return x509.load_pem_x509_certificate((keystore.enclave(name).folder / "cert.pem").read_bytes())


def use(folder):
    """Load an enclave as a session does."""
    found = find_enclave(folder, "viewer")
    found.check()
    return found.access_control


def contents(path):
    """Return all files below a folder."""
    return {each: each.read_bytes() for each in Path(path).rglob("*") if each.is_file()}


def test_only_the_owner_can_read_what_is_made(keystore):
    """Folders have mode 0700 and files 0600; the authority's certificate is public."""
    wide = {
        str(each.relative_to(keystore.path)): oct(stat.S_IMODE(each.stat().st_mode))
        for each in (keystore.path, *keystore.path.rglob("*"))
        if stat.S_IMODE(each.stat().st_mode) & 0o077
    }

    assert {"public/ca.cert.pem": "0o644"} == wide


def test_certificates_name_their_member_and_where_simulators_are(keystore):
    """Servers' certificates are for servers and clients, others for clients alone; all are of one authority."""
    authority = x509.load_pem_x509_certificate((keystore.path / "public" / "ca.cert.pem").read_bytes())
    server, client = certificate(keystore, "simulator"), certificate(keystore, "nurses")
    names = server.extensions.get_extension_for_class(x509.SubjectAlternativeName).value

    assert authority.extensions.get_extension_for_class(x509.BasicConstraints).value.ca
    assert "CN=nurses" == client.subject.rfc4514_string()
    assert "localhost" in names.get_values_for_type(x509.DNSName)
    assert {"127.0.0.1", "::1"} == {str(each) for each in names.get_values_for_type(x509.IPAddress)}
    for one, purposes in ((server, 2), (client, 1)):
        one.verify_directly_issued_by(authority)
        found = list(one.extensions.get_extension_for_class(x509.ExtendedKeyUsage).value)
        assert purposes == len(found)
        assert ExtendedKeyUsageOID.CLIENT_AUTH in found


def test_a_folder_that_exists_is_left_alone(tmp_path, keystore):
    """A keystore is replaced only with force, and other folders never."""
    before = contents(keystore.path)
    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.tex").touch()

    for path, force, text in (
        (keystore.path, False, "exists; name another folder, or replace the keystore there with --force"),
        (other, True, "exists and is no keystore"),
    ):
        with case(path.name), pytest.raises(BadOptions, match=text):
            Keystore.create(path, MEMBERS, Network(), force=force)
    assert before == contents(keystore.path)

    Keystore.create(keystore.path, MEMBERS, Network(), force=True)
    assert not set(before.values()) & {each for path, each in contents(keystore.path).items() if path.suffix == ".pem"}


def test_what_can_not_be_made_leaves_nothing(tmp_path):
    """An invalid name is refused before anything is written."""
    for members, text in (
        ([Member("a b", "viewer")], "'a b' is not a name"),
        ([Member("a", "viewer"), Member("a", "operator")], "'a' exists already"),
        ([Member("a", "controller", ("_world",))], "'_world' is no robot's name"),
        ([Member(SIMULATOR, "viewer")], "'simulator' is the name of the simulator's enclave"),
        ([Member("a", SIMULATOR)], "is named 'simulator'"),
        ([Member("a", "root")], "no role 'root'; there are: simulator, controller, viewer, operator"),
    ):
        with case(text), pytest.raises(BadOptions, match=text):
            Keystore.create(tmp_path / "keys", members, Network())
    for fields, text in (({"hosts": ("a b",)}, "--host 'a b'"), ({"prefix": "a//b"}, "--prefix")):
        with case(text), pytest.raises(BadOptions, match=text):
            Network(**fields)

    assert [] == list(tmp_path.iterdir())


def test_a_file_in_the_way_is_one_line(tmp_path):
    """The error names the folder."""
    (tmp_path / "file").touch()

    with pytest.raises(BadOptions, match=r"file/keys: (not a directory|file exists)"):
        Keystore.create(tmp_path / "file" / "keys", MEMBERS, Network())


def test_a_member_is_added_with_its_rights(keystore):
    """The policy of all enclaves has the new member; the others' certificates stay as they are."""
    before = certificate(keystore, "viewer")
    keystore.add(Member("porters", "controller", ("m_o",)))
    again = Keystore(keystore.path)

    assert before == certificate(again, "viewer")
    for name in again.members:
        policy = again.enclave(name).access_control
        assert policy.may_query("porters", "hmrsim/m_o/wait/_action/send_goal").allowed
        assert not policy.may_query("porters", "hmrsim/eve/wait/_action/send_goal").allowed


def test_a_revoked_member_may_nothing_and_its_name_is_never_given_again(keystore):
    """A revoked name can't be used again, as its old certificate is still valid."""
    keystore.revoke("nurses")
    again = Keystore(keystore.path)

    assert ("nurses",) == again.revoked
    assert not again.enclave("simulator").access_control.may_query("nurses", "hmrsim/_world/info").allowed
    with pytest.raises(BadOptions, match="'nurses' exists already, or is revoked"):
        again.add(Member("nurses", "viewer"))
    with pytest.raises(BadOptions, match="'nurses' is revoked"):
        again.renew(["nurses"])


def test_the_simulator_is_not_revoked(keystore):
    """The simulator can't be revoked, as all clients trust its name."""
    with pytest.raises(BadOptions, match="which all clients trust; make a new keystore instead"):
        keystore.revoke("simulator")


def test_renewing_makes_new_certificates_and_keys(keystore):
    """Other members keep their certificates."""
    before = {name: (certificate(keystore, name), keystore.members[name].expires) for name in keystore.members}

    assert ["viewer"] == keystore.renew(["viewer"], days=900.0)
    after = {name: (certificate(keystore, name), keystore.members[name].expires) for name in keystore.members}
    assert {"viewer"} == {name for name in before if before[name] != after[name]}
    assert after["viewer"][1] > before["viewer"][1]
    with pytest.raises(BadOptions, match="has no 'eve'; there are: simulator, nurses, fleet, viewer, operator"):
        keystore.renew(["eve"])


def test_a_damaged_keystore_is_one_line(keystore):
    """The error names the file."""
    file = keystore.path / "keystore.json"
    for text in (
        "",
        "[]",
        "{}",
        '{"prefix": "hmrsim", "ros_domain_id": 1e999, "hosts": [], "members": []}',
        "[" * 10**5,
    ):
        file.write_text(text, encoding="utf-8")
        with case(text[:20]), pytest.raises(BadOptions, match=r"keystore\.json: not a keystore"):
            Keystore(keystore.path)
    with pytest.raises(BadOptions, match="is no keystore; make one with"):
        Keystore(keystore.path / "private")


def test_an_enclave_is_found_by_its_name_its_role_or_its_folder(keystore):
    """The error lists the members of an ambiguous role."""
    assert "nurses" == find_enclave(keystore.path, "nurses").name
    assert "viewer" == find_enclave(keystore.path, "viewer").name
    assert "nurses" == find_enclave(keystore.path / "enclaves" / "nurses", "viewer").name
    with pytest.raises(
        BadOptions, match="several enclaves with the role 'controller'; choose with --role: fleet, nurses"
    ):
        find_enclave(keystore.path, "controller")
    with pytest.raises(BadOptions, match="no enclave 'root'; choose with --role: fleet, nurses, operator, simulator"):
        find_enclave(keystore.path, "root")
    with pytest.raises(BadOptions, match="has no enclaves; make some with `hmrsim security create"):
        find_enclave(keystore.path / "public", "viewer")


def test_a_damaged_enclave_is_one_line(keystore):
    """The error names the file that is missing or damaged, and what has expired."""
    enclave = keystore.enclave("viewer")
    other = (keystore.enclave("nurses").folder / "key.pem").read_text(encoding="utf-8")
    for file, text, message in (
        ("key.pem", None, r"key\.pem: no such file"),
        ("key.pem", "", r"cert\.pem and key\.pem in .*: .*; copy the enclave again"),
        ("key.pem", other, r"cert\.pem and key\.pem in .*: key values mismatch"),
        ("cert.pem", "-----BEGIN CERTIFICATE-----", r"cert\.pem and key\.pem in .*: .*; copy the enclave again"),
        ("ca.cert.pem", "nothing", r"ca\.cert\.pem in .*: .*; copy the enclave again"),
        ("policy.json", "{}", r"policy\.json: not an access control of Zenoh"),
        ("enclave.json", "{}", r"enclave\.json does not describe an enclave"),
        ("enclave.json", '{"name": 1}', r"enclave\.json does not describe an enclave"),
    ):
        path = enclave.folder / file
        kept = path.read_bytes()
        path.unlink() if text is None else path.write_text(text, encoding="utf-8")
        with case(file), pytest.raises(BadOptions, match=message):
            use(enclave.folder)
        path.write_bytes(kept)


def test_an_expired_enclave_says_so(keystore, tmp_path):
    """The error names the command that renews the certificate."""
    expired = keystore.stranger("viewer", -1.0, tmp_path / "expired")

    with pytest.raises(
        BadOptions, match=r"'viewer' in .* expired on .*; make another with `hmrsim security renew DIR viewer`"
    ):
        expired.check()


def test_a_configuration_for_other_programs_is_complete(keystore):
    """The session file has no paths, so that it can be copied to the machine of a ROS node."""
    text = (keystore.enclave("nurses").folder / "session.json5").read_text(encoding="utf-8")
    session = json.loads(text)

    assert str(keystore.path) not in text
    assert ["tls/localhost:7447"] == session["connect"]["endpoints"]
    assert not (keystore.enclave("simulator").folder / "session.json5").exists()


def test_the_configuration_for_other_programs_connects_to_a_name_or_an_ipv4_address(tmp_path):
    """Zenoh checks no certificate at an IPv6 address."""
    for hosts, expected in ((("fd00::7", "10.0.0.7"), "10.0.0.7"), (("::1",), "localhost")):
        store = Keystore.create(tmp_path / expected, MEMBERS, Network(hosts=hosts))
        session = json.loads((store.enclave("nurses").folder / "session.json5").read_text(encoding="utf-8"))

        assert [f"tls/{expected}:7447"] == session["connect"]["endpoints"]


def test_a_link_to_a_keystore_is_replaced_and_not_what_it_leads_to(tmp_path, keystore):
    """The old keystore is still where it was."""
    before = contents(keystore.path)
    link = tmp_path / "link"
    link.symlink_to(keystore.path)

    Keystore.create(link, MEMBERS, Network(), force=True)
    assert before == contents(keystore.path)
    assert not link.is_symlink()
    assert [keystore.path, link] == sorted(tmp_path.iterdir())


def test_a_member_is_revoked_whose_folder_was_moved(tmp_path, keystore):
    """Revoking a member whose folder is a link leaves the target."""
    moved = tmp_path / "elsewhere"
    (keystore.path / "enclaves" / "nurses").rename(moved)
    keystore.revoke("nurses")
    (keystore.path / "enclaves" / "fleet").rename(tmp_path / "linked")
    (keystore.path / "enclaves" / "fleet").symlink_to(tmp_path / "linked")
    keystore.revoke("fleet")
    policy = Keystore(keystore.path).enclave("simulator").access_control

    assert {"nurses", "fleet"}.isdisjoint(policy.rules)
    assert (tmp_path / "linked" / "key.pem").exists()
    assert not (keystore.path / "enclaves" / "fleet").is_symlink()


def test_names_that_people_have_written_into_a_keystore_are_checked(tmp_path, keystore):
    """Names can't leave the folder of enclaves, or stand for many robots."""
    file = keystore.path / "keystore.json"
    whole = json.loads(file.read_text(encoding="utf-8"))
    for place, value in (("name", "../../other"), ("robots", ["*"]), ("role", "root"), ("name", "viewer")):
        changed = json.loads(json.dumps(whole))
        changed["members"][1][place] = value
        file.write_text(json.dumps(changed), encoding="utf-8")
        with case(f"{place}: {value}"), pytest.raises(BadOptions, match=r"keystore\.json: not a keystore: "):
            Keystore(keystore.path)
    file.write_text(json.dumps({**whole, "revoked": ["../other"]}), encoding="utf-8")
    with pytest.raises(BadOptions, match=r"'\.\./other' is not a name"):
        Keystore(keystore.path)
    assert ["keys"] == [each.name for each in tmp_path.iterdir()]


def test_no_certificate_outlives_its_authority(keystore):
    """The reported expiry is the certificate's."""
    ends = x509.load_pem_x509_certificate((keystore.path / "public" / "ca.cert.pem").read_bytes()).not_valid_after_utc
    keystore.renew(["viewer"], days=36_500.0)

    assert ends == certificate(keystore, "viewer").not_valid_after_utc
    assert ends.isoformat(timespec="seconds") == keystore.members["viewer"].expires


def test_pipes_are_not_waited_for(keystore):
    """Pipes are rejected in enclaves and keystores."""
    for file in ("enclaves/viewer/enclave.json", "enclaves/viewer/policy.json", "enclaves/viewer/key.pem"):
        with case(file), in_place_of(keystore.path / file), pytest.raises(BadOptions, match="not a regular"):
            use(keystore.path / "enclaves" / "viewer")
    with (
        in_place_of(keystore.path / "private" / "ca.key.pem"),
        pytest.raises(BadOptions, match="not a regular"),
    ):
        keystore.renew(["viewer"])
    with in_place_of(keystore.path / "keystore.json"), pytest.raises(BadOptions, match="not a regular"):
        Keystore(keystore.path)


@contextmanager
def in_place_of(path):
    """Replace a file by a pipe."""
    kept = path.read_bytes()
    path.unlink()
    os.mkfifo(path)
    yield
    path.unlink()
    path.write_bytes(kept)


def test_what_another_command_has_changed_meanwhile_is_kept(keystore):
    """A revoked member stays revoked when an older view of the keystore adds another member."""
    earlier = Keystore(keystore.path)
    keystore.revoke("nurses")
    earlier.add(Member("porters", "controller"))
    again = Keystore(keystore.path)

    assert ("nurses",) == again.revoked
    assert "nurses" not in again.enclave("simulator").access_control.rules


def test_two_commands_do_not_change_a_keystore_at_the_same_time(keystore):
    """The second command is rejected and changes nothing."""
    before = contents(keystore.path)
    folder = os.open(keystore.path, os.O_RDONLY)
    fcntl.flock(folder, fcntl.LOCK_EX)
    try:
        with pytest.raises(BadOptions, match="keys is being changed by another command; try again"):
            keystore.revoke("nurses")
    finally:
        os.close(folder)

    assert before == contents(keystore.path)

"""Hosts that measure themselves: what travels, what comes back, and what is said of those that fail."""

import gzip
import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import msgspec
import pytest
from click.testing import CliRunner, Result

from alloc import AllocError
from bench import load
from bench.__main__ import cli
from bench.fleet import lead
from bench.fleet.lead import Host, HostRun, folders, hosts, keep, pack, run_fleet, run_here, unpack
from bench.record import FILE_NAME
from bench.record.file import PREVIOUS
from bench.report.terminal import objections
from bench.results.rows import read_run
from tests import made_up
from tests.clusters import loopback_cluster
from tests.runs import started, wait_for
from tests.vehicle_files import GOOD

DECK, KEEL = Host("10.0.0.1", "tcp://10.0.0.1:1", "deck"), Host("10.0.0.2", "tcp://10.0.0.2:1", "keel")
QUICK = ("--method", "pinv", "--demands", "inactive", "--repeats", "1", "--budget-ms", "1", "--n", "5")


class Finished:
    """A future of Dask's as the fleet sees it."""

    def __init__(self, status: str, outcome: object = None) -> None:
        self.status, self.outcome = status, outcome

    def result(self) -> object:
        """Result of the task."""
        return self.outcome

    def exception(self) -> object:
        """Error of the task."""
        return self.outcome

    def cancel(self) -> None:
        """Nothing waits for it any more."""
        self.status = "cancelled"


class Cluster:
    """A client of Dask's as the fleet sees it: workers with the time of their last sign, and futures."""

    def __init__(self, seen: dict[str, float], futures: dict[str, Finished]) -> None:
        self.seen, self.futures = seen, futures
        self.scheduler = self

    def sync(self, question: Callable[..., Any], **arguments: Any) -> Any:
        """The answer to a question that a scheduler is asked."""
        return question(**arguments)

    def identity(self, n_workers: int) -> dict[str, Any]:
        """A scheduler's account of its workers."""
        described = {
            address: {"host": address.split("//")[1].split(":")[0], "name": address, "last_seen": at}
            for address, at in self.seen.items()
        }
        return {"workers": described}

    def submit(
        self, function: Callable[..., HostRun], *arguments: object, workers: list[str], **_: object
    ) -> Any:
        """The future of that worker."""
        assert function is run_here
        return self.futures[workers[0]]


def outcome(cluster: Cluster, limit_s: float = 100.0) -> dict[str, HostRun]:
    """Answers of a fleet of DECK and KEEL."""
    back = run_fleet(cluster, [DECK, KEEL], pack(()), limit_s, lambda said: None)  # type: ignore[arg-type]  # Dask's in part
    return {host.name: run for host, run in back}


GOOD_RUN = HostRun(machine="board", record=b"packed")


@pytest.mark.parametrize(
    ("future", "last_seen_s_ago", "reason"),
    [
        (
            Finished("error", ModuleNotFoundError("No module named 'bench'")),
            0,
            "lacks a package (No module named",
        ),
        (Finished("error", OSError("no space left")), 0, "OSError: no space left"),
        (Finished("pending"), 1000, "hangs: no sign of life for 1000 s"),
        (Finished("pending"), None, "its worker died, or lost the network"),
    ],
)
def test_a_host_that_fails_is_a_reason_and_the_others_go_on(
    future: Finished, last_seen_s_ago: float | None, reason: str
) -> None:
    now = time.time()
    seen = {DECK.worker: now}
    if last_seen_s_ago is not None:
        seen[KEEL.worker] = now - last_seen_s_ago
    back = outcome(Cluster(seen, {DECK.worker: Finished("finished", GOOD_RUN), KEEL.worker: future}))
    assert back["deck"] == GOOD_RUN
    assert reason in back["keel"].reason
    assert future.status != "pending", "nothing is left under way"


def test_a_host_that_does_not_end_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lead, "GRACE_S", 0.0)
    seen = dict.fromkeys((DECK.worker, KEEL.worker), time.time())
    futures = {DECK.worker: Finished("finished", GOOD_RUN), KEEL.worker: Finished("pending")}
    back = outcome(Cluster(seen, futures), limit_s=0.01)
    assert "did not end within the limit" in back["keel"].reason


def test_a_host_with_several_workers_measures_itself_once() -> None:
    seen = dict.fromkeys(("tcp://10.0.0.1:5", "tcp://10.0.0.1:4", "tcp://10.0.0.2:9"), 0.0)
    assert [host.worker for host in hosts(Cluster(seen, {}))] == ["tcp://10.0.0.1:4", "tcp://10.0.0.2:9"]  # type: ignore[arg-type]  # Dask's in part


def test_files_that_options_name_travel_along(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    for place in ("cross.yaml", "a/cross.yaml"):
        (tmp_path / place).write_text(f"# {place}\n{GOOD}")
    parcel = pack(["--vehicle", f"{tmp_path}/cross.yaml", f"--vehicle={tmp_path}/a/cross.yaml", "--quick"])
    assert parcel.arguments == ("--vehicle", "1/cross.yaml", "--vehicle=2/cross.yaml", "--quick")
    unpack(parcel, tmp_path / "there")
    assert (tmp_path / "there" / "1" / "cross.yaml").read_text().startswith("# cross.yaml")
    assert (tmp_path / "there" / "2" / "cross.yaml").read_text().startswith("# a/cross.yaml")


def test_what_files_name_beside_them_and_a_bag_s_folder_travel_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A host refused the vehicle for its curve and the bag, and a method was taken for a file of its name."""
    monkeypatch.chdir(tmp_path)
    texts = {"rov.yaml": "curve: mine.csv", "mine.csv": "", "plug.py": "import helper", "helper.py": ""}
    texts |= {"other.py": "", "pinv": "", "dive.bag": "", "bag/metadata.yaml": "", "bag/bag_0.db3": ""}
    (tmp_path / "bag").mkdir()
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    asked = ["--vehicle", "rov.yaml", "--plugin=plug.py", "--method", "pinv", "--demands", "bag"]
    parcel = pack([*asked, "--demands", "dive.bag#/a"])
    assert parcel.arguments[1:3] == ("1/rov.yaml", "--plugin=2/plug.py")
    assert parcel.arguments[4:] == ("pinv", "--demands", "6/bag", "--demands", "8/dive.bag#/a")
    beside = {"1/rov.yaml", "1/mine.csv", "2/plug.py", "2/helper.py"}
    assert set(parcel.files) == beside | {"6/bag/metadata.yaml", "6/bag/bag_0.db3", "8/dive.bag"}


def test_a_host_that_can_t_run_says_why(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))  # the host's lock stays there
    back = run_here(pack(["--vehicle", "magic"]), 60)
    assert back.machine
    assert "no vehicle 'magic'" in back.reason
    assert back.code == 2


def test_a_run_that_outlasts_its_limit_is_ended(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    began = time.monotonic()
    back = run_here(pack(["--all"]), 1.0)
    assert "took longer than 1 s" in back.reason
    assert time.monotonic() - began < 30


def test_machines_alike_have_folders_with_their_workers_names() -> None:
    board, other = HostRun(machine="pi-4"), HostRun(machine="pi-5")
    assert folders([(DECK, board), (KEEL, board), (DECK, other)]) == ["pi-4-deck", "pi-4-keel", "pi-5"]


def test_an_older_record_is_kept_beside_a_new_one(tmp_path: Path) -> None:
    texts = (b"first", b"second", b"third", b"fourth")
    earlier = [keep(HostRun(machine="pi", record=gzip.compress(text)), tmp_path / "pi") for text in texts]
    assert earlier == [False, True, True, True]
    assert (tmp_path / "pi" / FILE_NAME).read_bytes() == b"fourth"
    assert (tmp_path / "pi" / PREVIOUS).read_bytes() == b"third"
    assert {path.read_bytes() for path in (tmp_path / "pi").iterdir()} == set(texts)
    (tmp_path / "file").touch()
    with pytest.raises(AllocError, match="give another --out"):
        keep(HostRun(machine="pi", record=gzip.compress(b"fifth")), tmp_path / "file")


def test_records_come_back_from_a_scheduler_s_hosts_also_where_one_dies(tmp_path: Path) -> None:
    """Two hosts by two loopback addresses; the vehicle is a file that only the caller has."""
    vehicle = tmp_path / "cross.yaml"
    vehicle.write_text(GOOD)
    out = tmp_path / "out"
    with loopback_cluster(tmp_path) as cluster:
        cluster.worker(host="127.0.0.1", name="deck")
        keel = cluster.worker(host="127.0.0.2", name="keel")
        log = tmp_path / "scheduler-0.log"
        wait_for(lambda: log.read_text().count("Register worker") == 2, 60)
        options = ("--scheduler", cluster.address, "--out", str(out), "--vehicle", str(vehicle), *QUICK)
        fleet = started("-m", "bench", "fleet", *options)
        assert fleet.stdout is not None
        first = fleet.stdout.readline().decode()
        assert "2 hosts: 127.0.0.1, 127.0.0.2" in first
        keel.kill()
        printed = fleet.communicate(timeout=120)[0].decode()
    assert fleet.returncode == 3, printed
    assert "127.0.0.2: its worker died, or lost the network" in printed
    (folder,) = out.iterdir()
    assert {row.vehicle for row in load(folder) if row.method == "pinv"} == {"cross"}
    assert (folder / "report.md").is_file()


def fleet_of(out: Path, monkeypatch: pytest.MonkeyPatch, sent: dict[Host, HostRun]) -> Result:
    """The command, where hosts send these."""
    monkeypatch.setattr("bench.fleet.cluster.cluster", lambda *_, **__: nullcontext())
    monkeypatch.setattr("bench.fleet.cluster.wait_for_workers", lambda _: None)
    monkeypatch.setattr("bench.fleet.lead.hosts", lambda _: list(sent))
    monkeypatch.setattr("bench.fleet.lead.run_fleet", lambda *_: iter(sent.items()))
    command = ["fleet", "--scheduler", "tcp://10.0.0.1:1", "--out", str(out)]
    return CliRunner().invoke(cli, command, standalone_mode=False)


def test_a_fleet_says_once_how_logs_were_understood(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A log in the wrong frame was one in the right, for all that a fleet said."""
    sent = {}
    for host in (DECK, KEEL):
        (tmp_path / host.name).mkdir()
        log = msgspec.structs.replace(made_up.problem("ukwial"), said=["log.csv: z may be up"], given=True)
        header = made_up.header(machine={"name": host.name})
        made = made_up.record(tmp_path / host.name, header, log, made_up.exact_cell("ukwial", "pinv", 1.0))
        packed = gzip.compress((made / FILE_NAME).read_bytes())
        sent[host] = HostRun(machine=host.name, record=packed)
    done = fleet_of(tmp_path / "out", monkeypatch, sent)
    assert done.return_value == 0, done.output
    assert done.output.count("log.csv: z may be up") == 1


def test_a_fleet_says_which_answers_end_it_with_1(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It named the report alone, and that a method was refused stood there for what was wrong beside."""
    made = made_up.whole(tmp_path) / FILE_NAME
    sent = HostRun(machine="pi", code=1, record=gzip.compress(made.read_bytes()))
    done = fleet_of(tmp_path / "out", monkeypatch, {DECK: sent})
    assert done.return_value == 1, done.output
    (said,) = objections(read_run(tmp_path / "out" / "pi").rows)
    assert said in done.output

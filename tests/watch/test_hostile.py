"""The live page and the log in bad company: many clients, silent ones, markup, a full disk."""

import asyncio
import json
import os
import re
import resource
import socket
import time
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files

import numpy as np
import pytest
from drawn_nights import text, world, write

from pyport.errors import BadInput
from pyport.recordings.from_table import from_table
from pyport.recordings.raw import NOTHING
from pyport.watch import Watch, follow, state
from pyport.watch.live import live
from pyport.watch.run import Options, Process

pytest.importorskip("uvicorn", reason="the extra `serve` is not installed")

from pyport.watch import serve as served_by
from pyport.watch.serve import LOOPBACK, Live, serve

#: Tests that run side by side serve from ports of their own.
PORT = 18767 + 10 * int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
CLIENTS = 500
#: Text in every column that may hold some.
MARKUP = "<script>alert(1)</script><img src=x onerror=alert(2)>"
TEXTS = ("source", "antenna", "receiver", "channel", "polarisation", "mine")


@pytest.fixture
def page():
    """Serve a page that shows a number."""
    shown = Live()
    shown.show({"rows": 1})
    served = serve(shown, port=PORT)
    yield shown
    served.stop()


def asked(request, port=PORT):
    """Return the first line of what comes back for some bytes."""
    with socket.create_connection(("127.0.0.1", port), timeout=10) as connection:
        connection.sendall(request)
        return connection.makefile("rb").readline().decode()


def request(path, method="GET", **headers):
    """Return a request for the page."""
    told = {"Host": f"127.0.0.1:{PORT}", "Connection": "close", **headers}
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {one}" for name, one in told.items())]
    return ("\r\n".join(lines) + "\r\n\r\n").encode()


def test_it_listens_on_loopback_alone(page):
    """Unless asked otherwise no other machine can connect."""
    with pytest.raises(OSError, match="refused"):
        socket.create_connection(("127.0.0.2", PORT), timeout=5)
    assert page.now()[0] == 1


def test_beyond_loopback_there_is_a_token():
    """Served elsewhere, its address carries a token, without which and with another it refuses."""
    served = serve(Live(), "127.0.0.3", PORT + 1)
    try:
        token = re.fullmatch(rf"http://127.0.0.3:{PORT + 1}/\?token=([\w-]{{22}})", served.address)
        assert "127.0.0.3" not in LOOPBACK
        for query, status in (("", 403), ("?token=x", 403), (f"?token={token[1]}", 200)):
            with socket.create_connection(("127.0.0.3", PORT + 1), timeout=10) as connection:
                connection.sendall(request(f"/state.json{query}"))
                assert connection.makefile("rb").readline().decode().split()[1] == str(status)
    finally:
        served.stop()


@pytest.mark.usefixtures("page")
@pytest.mark.parametrize(
    "path",
    [
        "/../../etc/passwd",
        "/static/watch.js",
        "//etc/passwd",
        "/%2e%2e/%2e%2e/etc/passwd",
        "/watch.css/../serve.py",
        "/watch.html%00.css",
        "/state.json/../../run.py",
        "/?file=/etc/passwd&command=id",
        "/events/../x",
    ],
)
def test_no_path_leads_to_a_file(path):
    """There are five addresses; what stands behind one changes nothing."""
    assert asked(request(path)).split()[1] == ("200" if path.startswith("/?") else "404")


@pytest.mark.usefixtures("page")
@pytest.mark.parametrize(
    "spoilt",
    [
        b"\0" * 100 + b"\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"GET /state.json HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: x\r\nContent-Length: -1\r\n\r\n",
        b"GET / HTTP/1.1\r\nX: " + b"a" * 200_000 + b"\r\n\r\n",
    ],
)
def test_spoilt_requests_are_refused(spoilt):
    """They are answered with a refusal, and the page goes on."""
    try:
        answer = asked(spoilt)
    except ConnectionResetError:  # closed before all was sent
        answer = ""
    assert not answer or answer.split()[1][0] == "4"
    assert asked(request("/state.json")).split()[1] == "200"


@pytest.mark.usefixtures("page")
def test_silent_connections_are_closed(monkeypatch):
    """Half a request or none: the connection is closed, and meanwhile others are served."""
    monkeypatch.setattr(served_by, "PATIENCE_S", 0.3)
    silent = [socket.create_connection(("127.0.0.1", PORT), timeout=10) for _ in range(200)]
    for one in silent[::2]:
        one.sendall(b"GET /state.json HTTP/1.1\r\nHost: 127.0")

    assert asked(request("/state.json")).split()[1] == "200"
    assert all(one.recv(1) == b"" for one in silent)


def test_five_hundred_viewers_get_the_news(page):
    """All of them see what is shown and what is shown then; others wait no longer than a second."""

    async def see():
        streams = await asyncio.gather(
            *(asyncio.open_connection("127.0.0.1", PORT) for _ in range(CLIENTS))
        )
        for _, writer in streams:
            writer.write(request("/events"))

        async def one(reader):
            while not (line := await reader.readline()).startswith(b"data: "):
                assert line
            return json.loads(line[6:])["rows"]

        first = await asyncio.gather(*(one(reader) for reader, _ in streams))
        page.show({"rows": 2})
        then = await asyncio.gather(*(one(reader) for reader, _ in streams))
        started = time.process_time()
        other, writer = await asyncio.open_connection("127.0.0.1", PORT)
        writer.write(request("/state.json"))
        assert (await other.readline()).split()[1] == b"200"
        took_s = time.process_time() - started
        for _, one_of_them in streams:
            one_of_them.close()
        return first, then, took_s

    # A browser of another test may have left a loop running in this thread.
    with ThreadPoolExecutor(1) as thread:
        first, then, took_s = thread.submit(asyncio.run, see()).result()

    assert first == [1] * CLIENTS
    assert then == [2] * CLIENTS
    assert took_s < 1


def test_viewers_that_never_read_hold_no_news_back(page):
    """The server keeps no more for them than fits into a connection."""
    page.show({"rows": 1, "text": "x" * 10**6})
    slow = [socket.create_connection(("127.0.0.1", PORT), timeout=10) for _ in range(20)]
    for one in slow:
        one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        one.sendall(request("/events"))
    for rows in range(2, 6):
        page.show({"rows": rows, "text": "x" * 10**6})

    with socket.create_connection(("127.0.0.1", PORT), timeout=10) as connection:
        connection.sendall(request("/state.json"))
        answer = connection.makefile("rb").read()
    assert json.loads(answer.partition(b"\r\n\r\n")[2])["rows"] == 5
    for one in slow:
        one.close()


def test_the_page_sets_text_as_text():
    """Nothing in it turns text into markup or code."""
    script = (files("pyport.watch") / "static" / "watch.js").read_text()

    assert not re.search(
        r"innerHTML|outerHTML|insertAdjacent|document\.write|eval|Function", script
    )
    assert not re.search(r"setAttribute\(\"?(on|href|src|style)", script)


def marked(payload):
    """Return what the page is sent with markup for every text in it."""
    if isinstance(payload, dict):
        return {name: marked(one) for name, one in payload.items()}
    if isinstance(payload, list):
        return [marked(one) for one in payload]
    return MARKUP if isinstance(payload, str) else payload


@pytest.mark.browser
def test_markup_in_every_text_column_stays_text(tmp_path, browser):
    """A log with a script in each, and then every text that is sent: shown, and nothing runs."""
    drawn = world()
    words = {name: np.full(len(drawn.past["az_deg"]), MARKUP) for name in TEXTS}
    write(tmp_path / "past.csv", drawn.past | words, drawn.header)
    words = {name: np.full(len(drawn.watched["az_deg"]), MARKUP) for name in TEXTS}
    write(tmp_path / "night.csv", drawn.watched | words, drawn.header)
    shown = Live()
    process = Process(
        Options(tmp_path / "night.csv", "altaz", tmp_path, history=str(tmp_path / "past.csv")),
        lambda _: None,
        lambda _: None,
    )
    process.show = lambda watch: shown.show(marked(live(watch)))
    served = serve(shown, port=PORT + 2)
    try:
        list(process.step())
        tab = browser.new_page()
        opened = []
        tab.on("dialog", lambda one: (opened.append(one.message), one.dismiss()))
        tab.goto(served.address)
        tab.wait_for_selector("#alarms li")
        assert MARKUP in tab.locator("#alarms").inner_text()
        assert tab.locator("img, main script").count() == 0
        assert opened == []
    finally:
        served.stop()


def test_a_log_of_one_endless_line(tmp_path):
    """A line without an end is refused when a megabyte of it is there; the rest is not read."""
    log = tmp_path / "night.csv"
    with log.open("wb") as file:
        file.write(b"az_deg,el_deg,d_el_arcsec\n1,30,")
        file.truncate(3 * 2**30)

    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(BadInput, match=r"night.csv:2: a line of more than 1 MB"):
        list(follow.new(log, NOTHING, follow.Cursor()))
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000  # kB


@pytest.fixture(scope="module")
def watch():
    """Return a watch with a past."""
    drawn = world()
    return Watch(drawn.past, header=drawn.header)


def test_a_spoilt_state_is_refused(watch, tmp_path):
    """Cut off, a byte changed anywhere, or no archive: one line, and no other exception."""
    path = tmp_path / "state.npz"
    state.save(watch, path, {"file": "night.csv"})
    whole = path.read_bytes()
    changed = (bytes([one ^ 85]).join((whole[:n], whole[n + 1 :]))
               for n, one in list(enumerate(whole))[:: len(whole) // 200])  # fmt: skip
    said = []
    for spoilt in (whole[:100], whole[:-10], b"", b"az_deg\n", *changed):
        path.write_bytes(spoilt)
        try:
            state.load(watch, path)
        except BadInput as error:
            said.append(str(error))

    assert len(said) > 100  # bytes of dates and names of an archive do not matter
    assert not any("\n" in one for one in said)


def test_a_clock_that_jumps(watch):
    """Back by a day or decades, ahead by ten years, standing still: each row is taken in."""
    drawn = world()
    moments = drawn.watched["time_utc"].astype("M8[us]").copy()
    for first, days in ((10, -1), (15, 3650), (20, -15_000)):
        moments[first : first + 5] += np.timedelta64(days, "D")
    moments[25:30] = moments[25]
    rows = from_table(drawn.watched | {"time_utc": moments}, drawn.header)
    for n in range(35):
        list(watch.replay(rows.take(slice(n, n + 1))))

    shown = live(watch)
    assert shown["rows"] == 35
    json.dumps(shown, allow_nan=False)


def test_a_full_disk(tmp_path):
    """What was kept stays; with room again the watch goes on as if nothing had been."""
    drawn = world()
    past = write(tmp_path / "past.csv", drawn.past, drawn.header)
    above, rows = text(drawn.watched, drawn.header)

    def watch(out, *pieces, room=None):
        log = tmp_path / f"{out}.csv"
        for piece in pieces:
            with log.open("a") as file:
                file.writelines(piece)
            options = Options(log, "altaz", tmp_path / out, history=str(past))
            process = Process(options, lambda _: None, lambda _: None)
            unlimited = resource.getrlimit(resource.RLIMIT_FSIZE)
            if room is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (room, unlimited[1]))
            try:
                list(process.step())
            finally:
                resource.setrlimit(resource.RLIMIT_FSIZE, unlimited)
        folder = tmp_path / out
        return lambda: [(folder / name).read_text() for name in ("events.jsonl", "status.json")]

    undisturbed = watch("quiet", above + rows[:12], rows[12:45])
    watch("full", above + rows[:12])
    kept = (tmp_path / "full" / "state.npz").read_bytes()
    for room in (100, 3000):
        with pytest.raises(OSError, match="File too large"):
            watch("full", rows[12:45] if room == 100 else [], room=room)
        assert (tmp_path / "full" / "state.npz").read_bytes() == kept
    assert watch("full", [])() == undisturbed()

"""The server: on the loopback, for its own pages, with files of its own and no other."""

import logging
import re
import socket
import urllib.error
import urllib.request

import pytest

import nonsmooth as ns
from nonsmooth.errors import OptionError, RunError
from nonsmooth.explorer.server import check_origins

pytest.importorskip("bokeh", reason="the page is made with Bokeh, the extra `explore`")


@pytest.fixture(scope="module")
def page():
    made = ns.explore(ns.models.soft_impact(), browser=False)
    yield made
    made.stop()


def port_of(page):
    return int(re.search(r":(\d+)/", page.url)[1])


def get(page, path="/", **headers):
    request = urllib.request.Request(f"http://127.0.0.1:{port_of(page)}{path}", headers=headers)
    with urllib.request.urlopen(request, timeout=60) as answer:
        return answer.read().decode()


def test_all_that_the_page_loads_is_its_own(page):
    text = get(page)
    loaded = re.findall(r'<(?:script|link)[^>]*(?:src|href)="([^"]+)"', text)
    assert len(loaded) > 3
    assert not [place for place in loaded if re.match(r"(https?:)?//", place)]
    for place in loaded:
        assert get(page, "/" + place.lstrip("/"))
    script = get(page, "/page/page.js")
    for module in re.findall(r'from "\./(\w+\.js)"', script):
        assert "http" not in re.sub(r"//.*", "", get(page, f"/page/{module}"))


@pytest.mark.parametrize("path", ["/page/../view.py", "/page/%2e%2e/view.py", "/page/nothing.js"])
def test_other_files_are_not_served(page, path):
    with pytest.raises(urllib.error.HTTPError) as told:
        get(page, path)
    told.value.close()
    assert told.value.code in (403, 404)


def answer_to_socket(page, origin):
    """First line of the answer to a browser that asks for a socket, for a page of an origin."""
    lines = [
        "GET /ws HTTP/1.1", f"Host: 127.0.0.1:{port_of(page)}", "Upgrade: websocket",
        "Connection: Upgrade", "Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==",
        "Sec-WebSocket-Version: 13", "Sec-WebSocket-Protocol: bokeh, token", f"Origin: {origin}",
        "", "",
    ]  # fmt: skip
    with socket.create_connection(("127.0.0.1", port_of(page)), timeout=60) as line:
        line.sendall("\r\n".join(lines).encode())
        return line.recv(200).decode().split("\r\n")[0]


def test_sockets_are_for_pages_of_this_server(page):
    for origin in ("http://evil.example", "http://evil.example:80", "null"):
        assert " 403 " in answer_to_socket(page, origin)
    assert " 403 " not in answer_to_socket(page, f"http://127.0.0.1:{port_of(page)}")


def test_other_machines_do_not_reach_it(page):
    """A port of the loopback is free on the other addresses of the machine."""
    with socket.socket() as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        other.bind(("127.0.0.2", port_of(page)))  # it would be taken, were all addresses


def test_a_page_that_is_closed_while_it_is_told_something_is_no_news(page):
    assert not logging.getLogger("bokeh.server.views.ws").isEnabledFor(logging.WARNING)


def test_a_port_that_is_taken_is_told(page):
    with pytest.raises(RunError, match="cannot be served"):
        ns.explore(port=port_of(page), browser=False)


def test_a_notebook_shows_the_page(page):
    assert page._repr_html_().startswith(f'<iframe src="http://127.0.0.1:{port_of(page)}/#model=')
    assert "stop()" in repr(page)


@pytest.mark.parametrize(
    "origin", ["*", "*:5006", "http://host:1", "a b", "host:port", "", "host", "[::1]"]
)
def test_an_origin_is_a_host_and_no_pattern(origin):
    with pytest.raises(OptionError, match="allow_origin"):
        check_origins([origin])
    assert check_origins(["lecture.example.org:5006", "[::1]:80"]) == [
        "lecture.example.org:5006",
        "[::1]:80",
    ]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"port": 70_000}, "port = 70000"),
        ({"port": "80"}, "port = '80'"),
        ({"work_limit": 0}, "work_limit = 0"),
        ({"work_limit": True}, "work_limit = True"),
        ({"link": "nothing=1"}, "unknown word 'nothing'"),
        ({"system": "moling"}, "give a System"),
        ({"allow_origin": ["*"]}, "allow_origin"),
    ],
)
def test_wrong_options_are_refused_before_anything_is_served(options, said):
    with pytest.raises(OptionError, match=re.escape(said)):
        ns.explore(**options, browser=False)

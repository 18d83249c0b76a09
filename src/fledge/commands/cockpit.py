"""The command of the cockpit."""

from pathlib import Path

from fledge import console
from fledge.commands.options import Attach, Folder, Maybe, NewFile, PemFile, Port


def cockpit(
    host: Maybe = "127.0.0.1",
    port: Port = 8000,
    demos: Folder = Path("demos"),
    policies: Folder = Path("policies"),
    attach: Attach = None,
    certificate: PemFile = None,
    key: PemFile = None,
    json: NewFile = None,
) -> None:
    """Fly, demonstrate, watch, train and take over in a browser.

    Prints the address to open. A gamepad will do, the keyboard, or a touch screen.

    Ctrl-C ends it; what is being recorded is not lost.

    Args:
        host: Where to listen; on another address than this machine's own, a token is needed to come in.
        port: Where to listen; 0 finds a free one.
        demos: Where demonstrations go, and in its folder flights all others.
        policies: Where trained policies go, and from where they are taken.
        attach: Join a running `fledge fly --operator ws`: where its sticks are, 127.0.0.1:51002 say.
        certificate: For TLS, which browsers want before they hand a gamepad to a page from elsewhere: a PEM file.
        key: The certificate's key, a PEM file.
        json: Write what came of it to this file, too; with -, to standard output and nothing else there.
    """
    from fledge.cockpit.server import Cockpit, address, recipe

    opened = Cockpit(address(host or "127.0.0.1", port, certificate, key), demos, policies, attach)
    for path in opened.stock.recovered:
        console.note(f"recovered what a cockpit left that was killed: {path}")
    for line in recipe(opened.where):
        console.note(line)
    console.note(f"open {opened.where.url} ; Ctrl-C ends")
    found = opened.run()
    answers = found["answer_ms"]
    console.show(
        found,
        json,
        f"{found['ticks']:,} ticks, {found['missed']} missed; sticks were answered in {answers['p50']:.1f} ms, "
        f"99 % within {answers['p99']:.1f} ms",
    )

"""The unit of the service: sound by systemd's own word, exposed no more than 3.0, and with what the daemon relies on.

    service_unit.py UNIT
"""
import configparser
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

SKIPPED = 77
MOST_EXPOSED = 3.0
NEEDED = {"Type": "notify", "User": "gyrobench", "StateDirectory": "gyrobench", "RuntimeDirectory": "gyrobench",
          "Restart": "on-failure"}


def exposure(unit):
    """By `systemd-analyze security`, 0 to 10."""
    done = subprocess.run(["systemd-analyze", "security", "--offline=true", "--no-pager", str(unit)],
                          capture_output=True, text=True)
    found = re.search(r"Overall exposure level for \S+: ([\d.]+)", done.stdout)
    if not found:
        sys.exit(f"systemd-analyze security: {done.stdout}{done.stderr}")
    return float(found[1])


def keys_of(text):
    """The last value of each key of [Service]; those that may be given several times are not looked at."""
    parser = configparser.RawConfigParser(strict=False)
    parser.optionxform = str
    parser.read_string(text)
    return dict(parser["Service"])


def check_keys(service):
    found = [f"{key} is {service.get(key)!r}, expected {value!r}" for key, value in NEEDED.items()
             if service.get(key) != value]
    # Below 3 s the daemon would be told to be dead between two looks.
    if int(service.get("WatchdogSec", "0")) < 3:
        found.append("no WatchdogSec of at least 3 s")
    socket = pathlib.Path(tomllib.loads(pathlib.Path("config/stand.toml").read_text())["control_socket"])
    if socket.parent != pathlib.Path("/run", service.get("RuntimeDirectory", "?")):
        found.append(f"the control socket of config/stand.toml, {socket}, is not in its RuntimeDirectory")
    return found


def main():
    text = pathlib.Path(sys.argv[1]).read_text()
    found = check_keys(keys_of(text))
    if found:
        sys.exit("\n".join(found))
    if shutil.which("systemd-analyze") is None:
        print("no systemd-analyze here: the unit is not judged by it")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        unit = pathlib.Path(folder) / "gyrobenchd.service"
        # Where it is not installed there is no such program.
        text = re.sub(r"(?m)^ExecStart=\S+", f"ExecStart={shutil.which('true')}", text)
        unit.write_text(text)
        verified = subprocess.run(["systemd-analyze", "verify", "--man=no", str(unit)], capture_output=True, text=True)
        if verified.returncode != 0 or str(unit) in verified.stderr:
            sys.exit(f"systemd-analyze verify: {verified.stderr}")
        exposed = exposure(unit)
        bare = pathlib.Path(folder) / "bare.service"
        bare.write_text("[Service]\nExecStart=/bin/true\n")
        print(f"exposure {exposed}; of a unit that is not hardened {exposure(bare)}")
        if exposed > MOST_EXPOSED or exposure(bare) <= MOST_EXPOSED:
            sys.exit(f"expected at most {MOST_EXPOSED}, and more than that of a unit that is not hardened")
    return 0


if __name__ == "__main__":
    sys.exit(main())

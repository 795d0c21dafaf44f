"""What loads a daemon from outside, in a process of its own so that who measures is not slowed down with it."""
import multiprocessing
import os
import socket
import subprocess
import threading
import time

import bench as benches

CLIENTS = 100
OF_THEM_BUSY = 10
# As many commands as may be, each of them cheap.
HOSTILE = ("procedure = { summary = 'x', description = 'x', measures = {}, parameters = {} }\n"
           "function run(p)\nwhile true do bench.progress(0) end\nend\n")


def ask(path, method, target, body=b"", timeout_s=60.0):
    """Status and answer of one request; None where the daemon does not answer."""
    return benches.ask_socket(path, method.encode(), target.encode(), body, timeout_s)


def again(action, ends):
    while not ends.is_set():
        try:
            action()
        except OSError:  # dropped in the crowd, or the daemon is not there
            time.sleep(0.01)


def idle_client(path, ends, is_there):
    """Connected, and says nothing; comes again when it is dropped."""
    def stay():
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(path)
            is_there.set()
            connection.settimeout(0.5)
            while not ends.is_set():
                try:
                    if not connection.recv(1):
                        break
                except TimeoutError:
                    pass
        time.sleep(0.1)
    again(stay, ends)


def busy_client(path, ends, is_there):
    def look():
        ask(path, "GET", "/v1/status")
        is_there.set()
        time.sleep(0.05)
    again(look, ends)


def dry_run(path, ends):
    again(lambda: ask(path, "POST", "/v1/check", b'{"procedure": "hostile"}'), ends)


def crowd(path, ready, ends):
    there = [threading.Event() for _ in range(CLIENTS)]
    clients = [threading.Thread(target=busy_client if i < OF_THEM_BUSY else idle_client,
                                args=(path, ends, there[i]), daemon=True)
               for i in range(CLIENTS)]
    clients.append(threading.Thread(target=dry_run, args=(path, ends), daemon=True))
    for client in clients:
        client.start()
    for is_there in there:
        is_there.wait()
    ready.set()
    ends.wait()


class Crowd:
    """100 clients, ten of them asking for the status all the time, and dry runs of a hostile script one after the
    other."""

    def __init__(self, bench):
        self.ready, self.ends = multiprocessing.Event(), multiprocessing.Event()
        self.process = multiprocessing.Process(target=crowd, daemon=True,
                                               args=(str(bench.folder / "control.sock"), self.ready, self.ends))

    def __enter__(self):
        self.process.start()
        self.ready.wait(60)
        return self

    def __exit__(self, *_):
        self.ends.set()
        self.process.join(30)
        self.process.kill()


class SlowSubscriber:
    """Subscribed to all that is published, and takes nothing of it."""

    def __init__(self, bench):
        environment = {**os.environ, "GYROBENCH_CONFIG": str(bench.config)}
        self.process = subprocess.Popen([benches.BIN / "gyrobench", "watch", "--data", "--json"], env=environment,
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)

    def __enter__(self):
        # Its pipe is full soon, and it hangs from then on.
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()

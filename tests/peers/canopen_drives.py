"""Six drives on a CAN adapter: `canopen_drives.py PORT POSITION...`

PyPI `canopen` is the node (SDO server, NMT, heartbeat, EMCY); the state machine of CiA 402 and the PDOs
are here. Commands on standard input, one a line; one line of JSON answers each:

    state                      state, NMT state and history of each drive
    targets NODE               the target at each SYNC in operation enabled
    fault NODE CODE            that drive goes into fault and sends an EMCY
    silence NODE               that drive says nothing any more
"""

import json
import sys
import threading
import time

import canopen
from objects import dictionary

STATUS = {"switch on disabled": 0x40, "ready": 0x21, "switched on": 0x23, "enabled": 0x27,
          "quick stop": 0x07, "fault": 0x08}
LOCK = threading.Lock()


class Drive:
    def __init__(self, network, number, position):
        self.number, self.network = number, network
        self.node = network.add_node(canopen.LocalNode(number, dictionary(number)))
        self.store(0x6064, position)
        self.state, self.history, self.targets = "switch on disabled", ["switch on disabled"], []
        self.control, self.buffered, self.silent, self.velocity = 0, None, False, 0
        self.master_heard = None
        self.node.add_write_callback(self.written)
        network.subscribe(0x200 + number, self.rpdo)
        network.subscribe(0x080, self.sync)
        # boot-up, then waiting to be configured
        self.node.nmt.send_command(0)
        self.node.nmt.send_command(0x80)

    def load(self, index, sub=0):
        data = self.node.get_data(index, sub)
        return int.from_bytes(data, "little", signed=index in (0x6064, 0x607A))

    def store(self, index, value):
        variable = self.node.object_dictionary[index]
        self.node.data_store.setdefault(index, {})[0] = variable.encode_raw(value)

    def go(self, state):
        if state != self.state:
            self.state = state
            self.history.append(state)

    def written(self, index, subindex, od, data):
        if index == 0x6060:
            self.store(0x6061, int.from_bytes(data, "little", signed=True))
        if index == 0x1016:
            master = int.from_bytes(data, "little") >> 16
            self.network.subscribe(0x700 + master, self.master_heartbeat)

    def master_heartbeat(self, can_id, data, timestamp):
        self.master_heard = time.monotonic()

    def rpdo(self, can_id, data, timestamp):
        with LOCK:
            if self.node.nmt.state == "OPERATIONAL":
                self.buffered = bytes(data)

    def sync(self, can_id, data, timestamp):
        with LOCK:
            if self.node.nmt.state != "OPERATIONAL":
                return
            if self.buffered is not None:
                self.unpack(self.buffered)
                self.buffered = None
            self.act()
            if not self.silent:
                self.network.send_message(0x180 + self.number, self.packed())

    def mapping(self, index):
        for sub in range(1, self.load(index) + 1):
            entry = self.load(index, sub)
            yield entry >> 16, (entry & 0xFF) // 8

    def unpack(self, data):
        for index, size in self.mapping(0x1600):
            self.store(index, int.from_bytes(data[:size], "little", signed=index == 0x607A))
            data = data[size:]

    def packed(self):
        self.store(0x6041, STATUS[self.state] | 0x1200)
        return b"".join(self.node.get_data(index, 0)[:size] for index, size in self.mapping(0x1A00))

    def act(self):
        word, before = self.load(0x6040), self.control
        self.control = word
        if self.state == "fault":
            if word & ~before & 0x80:
                self.go("switch on disabled")
        elif word & 0x02 == 0:
            self.go("switch on disabled")
        elif word & 0x04 == 0:
            if self.state == "enabled":
                self.go("quick stop")
            elif self.state != "quick stop" or self.velocity == 0:
                self.go("switch on disabled")
        elif self.state == "quick stop":
            if self.velocity == 0:
                self.go("switch on disabled")
        elif word & 0x0F == 0x06:
            self.go("ready")
        elif word & 0x0F == 0x07 and self.state in ("ready", "enabled"):
            self.go("switched on")
        elif word & 0x0F == 0x0F and self.state in ("switched on", "enabled"):
            self.go("enabled")
        if self.state == "enabled" and self.load(0x6061) == 8:
            target = self.load(0x607A)
            self.targets.append(target)
            self.velocity = target - self.load(0x6064)
        else:
            self.velocity = int(self.velocity / 2)
        self.store(0x6064, self.load(0x6064) + self.velocity)

    def watch(self):
        """Quick stop when the master's heartbeat stays away, as it was configured to."""
        with LOCK:
            within = (self.load(0x1016, 1) & 0xFFFF) / 1000
            late = self.master_heard is not None and time.monotonic() - self.master_heard > within > 0
            if late and self.state == "enabled" and self.load(0x6007) == 3:
                self.go("quick stop")

    def fault(self, code):
        with LOCK:
            self.store(0x603F, code)
            self.go("fault")
            self.node.emcy.send(code, 1)

    def silence(self):
        with LOCK:
            self.silent = True
            self.node.nmt.stop_heartbeat()

    def told(self):
        return {"state": self.state, "nmt": self.node.nmt.state, "history": self.history,
                "targets": len(self.targets)}


def main():
    port, *positions = sys.argv[1:]
    network = canopen.Network()
    network.connect(interface="slcan", channel=port, bitrate=1_000_000, sleep_after_open=0.1)
    drives = {number: Drive(network, number, int(position))
              for number, position in enumerate(positions, 1)}

    def watch():
        while True:
            time.sleep(0.02)
            for drive in drives.values():
                drive.watch()

    threading.Thread(target=watch, daemon=True).start()
    print(json.dumps("ready"), flush=True)
    for line in sys.stdin:
        command, *arguments = line.split()
        answer = None
        if command == "state":
            with LOCK:
                answer = [drive.told() for drive in drives.values()]
        elif command == "targets":
            with LOCK:
                answer = list(drives[int(arguments[0])].targets)
        elif command == "fault":
            drives[int(arguments[0])].fault(int(arguments[1], 0))
        elif command == "silence":
            drives[int(arguments[0])].silence()
        print(json.dumps(answer), flush=True)
    network.disconnect()


if __name__ == "__main__":
    main()

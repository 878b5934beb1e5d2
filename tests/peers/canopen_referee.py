"""PyPI `canopen`'s own CiA 402 master judges a drive: `canopen_referee.py PORT NODE`

It maps the drive's PDOs in its own way, enables it, moves it, meets a fault (the drive makes one when
its target is 4242), resets it, and stops it. Ends with 0 and "passed", or with what it found.
"""

import sys
import time

import canopen
from canopen.profiles.p402 import BaseNode402
from objects import dictionary


def wait_for(what, check, seconds=10.0):
    end = time.monotonic() + seconds
    while not check():
        if time.monotonic() > end:
            sys.exit(f"not within {seconds} s: {what}")
        time.sleep(0.005)


def main():
    port, number = sys.argv[1], int(sys.argv[2])
    network = canopen.Network()
    network.connect(interface="slcan", channel=port, bitrate=1_000_000, sleep_after_open=0.1)
    node = BaseNode402(number, dictionary(number))
    # on a busy machine the drive's thread may come late
    for name in ("RESET_FAULT", "SWITCH_OP_MODE", "SWITCH_STATE_FINAL", "SWITCH_STATE_SINGLE", "CHECK_TPDO"):
        setattr(node, f"TIMEOUT_{name}", 3.0)
    node.sdo.RESPONSE_TIMEOUT = 3.0
    network.add_node(node)
    emergencies = []
    node.emcy.add_callback(lambda error: emergencies.append(error.code))

    node.nmt.state = "PRE-OPERATIONAL"
    node.sdo[0x1017].raw = 100
    for pdo, base, names in ((node.tpdo[1], 0x180, ("Statusword", "Position actual value")),
                             (node.rpdo[1], 0x200, ("Controlword", "Target position"))):
        pdo.cob_id, pdo.trans_type, pdo.enabled = base + number, 1, True
        pdo.clear()
        for name in names:
            pdo.add_variable(name)
        pdo.save()
    start = node.sdo[0x6064].raw
    node.rpdo[1]["Target position"].raw = start
    node.nmt.state = "OPERATIONAL"
    node.nmt.wait_for_heartbeat(5)
    if node.nmt.state != "OPERATIONAL":
        sys.exit(f"NMT state {node.nmt.state}")
    network.sync.start(0.01)
    node.rpdo[1].start(0.01)
    node.setup_402_state_machine(read_pdos=False)
    # until a TPDO came the library tells a statusword of its own, 0
    wait_for("the first statusword", lambda: node.statusword != 0)
    node.op_mode = "CYCLIC SYNCHRONOUS POSITION"
    if node.op_mode != "CYCLIC SYNCHRONOUS POSITION":
        sys.exit(f"mode {node.op_mode}")
    if node.state != "SWITCH ON DISABLED":
        sys.exit(f"at first {node.state}")
    node.state = "OPERATION ENABLED"

    def position():
        return node.tpdo[1]["Position actual value"].raw

    for target in (start + 10, start - 2000, start + 123):
        node.rpdo[1]["Target position"].raw = target
        wait_for(f"position {target}", lambda: position() == target)
    node.rpdo[1]["Target position"].raw = 4242
    wait_for("the fault", lambda: node.state == "FAULT")
    wait_for("the EMCY", lambda: emergencies == [0x8611])
    if node.sdo[0x603F].raw != 0x8611:
        sys.exit(f"error code {node.sdo[0x603F].raw:#x}")
    node.rpdo[1]["Target position"].raw = position()
    node.TIMEOUT_RESET_FAULT = 0.4
    node.reset_from_fault()
    if node.state != "OPERATION ENABLED":
        sys.exit(f"after the reset {node.state}")
    node.rpdo[1]["Controlword"].raw = 0x02
    wait_for("the quick stop", lambda: node.state == "SWITCH ON DISABLED")
    for index, code in ((0x2FFF, 0x06020000), (0x6041, 0x06010002)):
        try:
            node.sdo.download(index, 0, b"\0\0")
        except canopen.SdoAbortedError as refusal:
            if refusal.code != code:
                sys.exit(f"{index:#x}: abort {refusal.code:#010x}")
        else:
            sys.exit(f"{index:#x} was written")
    network.disconnect()
    print("passed")


if __name__ == "__main__":
    main()

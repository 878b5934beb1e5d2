//! A machine made of files: the trees of /sys and /dev that the kernel would show.

use super::*;
use std::collections::HashMap;
use std::fs;
use std::os::unix::fs::symlink;
use tempfile::TempDir;

/// A machine without devices.
struct Machine {
    folder: TempDir,
    cameras: HashMap<PathBuf, Result<Answer, i32>>,
    forbidden: Vec<PathBuf>,
}

impl Machine {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for path in ["sys/class", "sys/devices", "dev"] {
            fs::create_dir_all(folder.path().join(path)).unwrap();
        }
        Self { folder, cameras: HashMap::new(), forbidden: Vec::new() }
    }

    fn roots(&self) -> Roots {
        Roots { sys: self.folder.path().join("sys"), dev: self.folder.path().join("dev") }
    }

    fn devices(&self) -> Devices {
        devices(&self.roots(), self)
    }

    /// A file below the machine's root.
    fn write(&self, path: &str, text: &str) {
        let path = self.folder.path().join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    fn link(&self, link: &str, target: &str) {
        let link = self.folder.path().join(link);
        fs::create_dir_all(link.parent().unwrap()).unwrap();
        let target = self.folder.path().join(target);
        fs::create_dir_all(&target).unwrap();
        symlink(target, link).unwrap();
    }

    /// A device of a class, an interface of the USB device at `port` driven by `driver`.
    fn plug(&self, class: &str, name: &str, port: &str, driver: &str) {
        let interface = format!("sys/devices/pci0/usb1/{port}/{port}:1.0");
        self.write(&format!("sys/devices/pci0/usb1/{port}/idVendor"), "046d\n");
        self.link(&format!("sys/class/{class}/{name}/device"), &interface);
        if !self.folder.path().join(&interface).join("driver").exists() {
            self.link(&format!("{interface}/driver"), &format!("sys/bus/usb/drivers/{driver}"));
        }
        self.write(&format!("dev/{name}"), "");
    }

    fn add_camera(&mut self, name: &str, port: &str, answer: Result<Answer, i32>) {
        self.plug("video4linux", name, port, "uvcvideo");
        self.write(&format!("sys/class/video4linux/{name}/name"), "HD Webcam: HD Webcam\n");
        self.write(&format!("sys/class/video4linux/{name}/index"), "0\n");
        self.cameras.insert(self.roots().dev.join(name), answer);
    }
}

impl Ask for Machine {
    fn camera(&self, node: &Path) -> io::Result<Answer> {
        self.cameras[node].clone().map_err(io::Error::from_raw_os_error)
    }

    fn may_use(&self, node: &Path) -> bool {
        !self.forbidden.iter().any(|forbidden| forbidden == node)
    }
}

fn offers(formats: &[&str]) -> Result<Answer, i32> {
    Ok(Answer { captures: true, formats: formats.iter().map(|format| (*format).to_owned()).collect() })
}

/// What is printed, with the machine's own folder left out.
fn printed(machine: &Machine) -> String {
    machine.devices().to_string().replace(machine.folder.path().to_str().unwrap(), "")
}

#[test]
fn a_machine_with_nothing_says_so() {
    let machine = Machine::new();
    assert_eq!(machine.devices(), Devices::default());
    let text = printed(&machine);
    for title in ["Cameras", "Serial ports", "CAN interfaces"] {
        assert!(text.contains(&format!("{title}:\n  none (")), "{text}");
    }
    // Not even a /sys.
    let roots = Roots { sys: PathBuf::from("/nowhere/sys"), dev: PathBuf::from("/nowhere/dev") };
    assert_eq!(devices(&roots, &machine), Devices::default());
}

#[test]
fn cameras_come_with_name_place_and_formats() {
    let mut machine = Machine::new();
    machine.add_camera("video10", "1-4", offers(&["YUYV: 640x480"]));
    machine.add_camera("video2", "1-2.3", offers(&["YUYV: 640x480, 320x240", "MJPG (not read): 1280x720"]));
    machine.write("sys/devices/pci0/usb1/1-2.3/serial", "C525-0042\n");
    fs::create_dir_all(machine.roots().dev.join("v4l/by-id")).unwrap();
    symlink("../../video2", machine.roots().dev.join("v4l/by-id/usb-HD_Webcam-video-index0")).unwrap();

    let found = machine.devices();
    assert_eq!(found.cameras.len(), 2);
    assert_eq!(found.cameras[0].node, machine.roots().dev.join("video2"), "in the order of their numbers");
    assert!(
        printed(&machine).starts_with(
            "Cameras:
  /dev/video2  HD Webcam: HD Webcam, USB port 1-2.3, serial C525-0042, driver uvcvideo
      /dev/v4l/by-id/usb-HD_Webcam-video-index0
      YUYV: 640x480, 320x240
      MJPG (not read): 1280x720
  /dev/video10  HD Webcam: HD Webcam, USB port 1-4, driver uvcvideo
      YUYV: 640x480
"
        ),
        "{}",
        printed(&machine)
    );
}

#[test]
fn nodes_without_pictures_are_not_listed() {
    let mut machine = Machine::new();
    machine.add_camera("video0", "1-1", offers(&["YUYV: 640x480"]));
    machine.add_camera("video1", "1-1", Ok(Answer { captures: false, formats: Vec::new() }));
    // Nor is a further node that could not be asked: its camera says what is wrong.
    machine.add_camera("video2", "1-1", Err(13));
    machine.write("sys/class/video4linux/video2/index", "1\n");
    machine.write("sys/class/video4linux/v4l-subdev0/name", "sensor\n");
    let found = machine.devices();
    let nodes: Vec<_> = found.cameras.iter().filter_map(|camera| camera.node.file_name()).collect();
    assert_eq!(nodes, ["video0"]);
}

#[test]
fn cameras_that_do_not_answer_say_why() {
    let mut machine = Machine::new();
    machine.add_camera("video0", "1-1", Err(13));
    machine.add_camera("video1", "1-2", Err(5));
    let text = printed(&machine);
    assert!(text.contains("/dev/video0  HD Webcam") && text.contains("group 'video'"), "{text}");
    assert!(text.contains("does not answer: Input/output error"), "{text}");
}

#[test]
fn serial_ports_are_those_with_something_behind() {
    let mut machine = Machine::new();
    machine.plug("tty", "ttyUSB0", "1-1", "ftdi_sio");
    machine.plug("tty", "ttyACM3", "1-2", "cdc_acm");
    machine.write("sys/devices/pci0/usb1/1-2/product", "CANable\n");
    machine.write("sys/devices/pci0/usb1/1-2/serial", "00AB\n");
    for (name, kind) in [("ttyS0", "4\n"), ("ttyS1", "0\n")] {
        machine.link(&format!("sys/class/tty/{name}/device"), "sys/devices/platform/serial8250");
        machine.write(&format!("sys/class/tty/{name}/type"), kind);
    }
    machine.link("sys/devices/platform/serial8250/driver", "sys/bus/serial-base/drivers/port");
    machine.write("sys/class/tty/tty1/dev", "4:1\n");
    machine.write("sys/class/tty/ttyS9/type", "4\n");
    machine.forbidden.push(machine.roots().dev.join("ttyUSB0"));

    let text = printed(&machine);
    let ports = &text[text.find("Serial").unwrap()..text.find("\nCAN").unwrap()];
    assert_eq!(
        ports,
        "Serial ports:
  /dev/ttyACM3  CANable, USB port 1-2, serial 00AB, driver cdc_acm
  /dev/ttyS0  serial port
  /dev/ttyUSB0  serial port, USB port 1-1, driver ftdi_sio
      no permission: add your user to the group 'dialout' (`sudo usermod -aG dialout $USER`) and log in again
"
    );
}

#[test]
fn can_interfaces_tell_their_state() {
    let machine = Machine::new();
    for (name, kind, flags, mtu) in [
        ("can0", "280", "0x40080", "16"),
        ("vcan0", "280", "0x400c1", "72"),
        ("eth0", "1", "0x1003", "1500"),
        ("lo", "772", "0x9", "65536"),
    ] {
        for (attribute, value) in [("type", kind), ("flags", flags), ("mtu", mtu)] {
            machine.write(&format!("sys/class/net/{name}/{attribute}"), &format!("{value}\n"));
        }
    }
    machine.plug("net", "can0", "1-3", "gs_usb");
    let text = printed(&machine);
    assert!(
        text.ends_with(
            "CAN interfaces:
  can0  CAN, down, USB port 1-3, driver gs_usb
      bring it up with `sudo ip link set can0 up type can bitrate 1000000`
  vcan0  CAN FD, up
"
        ),
        "{text}"
    );
}

#[test]
fn the_machine_itself_can_be_asked() {
    // Whatever it has, nothing of it may stop the listing.
    let text = devices(&Roots::system(), &System).to_string();
    assert!(text.contains("Cameras:") && text.contains("CAN interfaces:"), "{text}");
}

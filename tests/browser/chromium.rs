//! Chromium without a window, driven through its protocol over a pair of pipes.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// The names under which systems have the browser.
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// How long a page may take.
const PATIENCE: Duration = Duration::from_secs(120);

/// A browser with one page.
pub struct Browser {
    process: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    session: Option<String>,
    calls: u64,
    /// Errors and requests of the page, as the browser tells them.
    told: Vec<Value>,
}

/// The browser, started; none with a note where it is absent.
pub fn start() -> Option<Browser> {
    let there = |name: &&&str| Command::new(name).arg("--version").output().is_ok_and(|it| it.status.success());
    let Some(name) = NAMES.iter().find(there) else {
        println!("skipped: chromium is absent, pages are not looked at");
        return None;
    };
    // The browser reads calls from descriptor 3 and writes answers to descriptor 4, each with a zero byte at its end.
    let line = "exec \"$0\" --headless --no-sandbox --disable-gpu --hide-scrollbars --remote-debugging-pipe \
                about:blank 3<&0 4>&1 </dev/null >/dev/null 2>&1";
    let mut shell = Command::new("sh");
    shell.args(["-c", line, name]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut process = shell.spawn().unwrap();
    let (to, from) = (process.stdin.take().unwrap(), BufReader::new(process.stdout.take().unwrap()));
    let mut browser = Browser { process, to, from, session: None, calls: 0, told: Vec::new() };
    let target = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
    let attach = json!({ "targetId": target["targetId"], "flatten": true });
    let session = browser.call("Target.attachToTarget", attach);
    browser.session = session["sessionId"].as_str().map(Into::into);
    for part in ["Page", "Runtime", "Log", "Network"] {
        browser.call(&format!("{part}.enable"), json!({}));
    }
    Some(browser)
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Browser {
    /// Calls a method of the protocol.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.calls += 1;
        let mut call = json!({ "id": self.calls, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            call["sessionId"] = json!(session);
        }
        self.to.write_all(format!("{call}\0").as_bytes()).unwrap();
        loop {
            let mut answer = Vec::new();
            self.from.read_until(0, &mut answer).unwrap();
            assert_eq!(answer.pop(), Some(0), "the browser ended in `{method}`");
            let answer: Value = serde_json::from_slice(&answer).unwrap();
            if answer["id"] == json!(self.calls) {
                assert!(answer.get("error").is_none(), "{method}: {answer}");
                return answer["result"].clone();
            }
            self.told.push(answer);
        }
    }

    /// The value of an expression in the page.
    pub fn value(&mut self, expression: &str) -> Value {
        let call = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let answer = self.call("Runtime.evaluate", call);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Opens a file at a width of the window.
    pub fn open(&mut self, page: &Path, width: u32) {
        self.resize(width);
        self.told.clear();
        self.call("Page.navigate", json!({ "url": format!("file://{}", page.display()) }));
        let begin = Instant::now();
        while self.value("document.readyState") != "complete" || self.value("location.protocol") != "file:" {
            assert!(begin.elapsed() < PATIENCE, "{} does not load", page.display());
            thread::sleep(Duration::from_millis(50));
        }
    }

    /// Sets the width of the window.
    pub fn resize(&mut self, width: u32) {
        let size = json!({ "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// Asks for pages that are `light`, `dark`, or as on paper: `print`.
    pub fn prefer(&mut self, look: &str) {
        let scheme = if look == "dark" { "dark" } else { "light" };
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        let media = if look == "print" { "print" } else { "" };
        self.call("Emulation.setEmulatedMedia", json!({ "media": media, "features": features }));
    }

    /// What the page complained about and asked the network for since it was opened, files beside it and data in it
    /// left out.
    pub fn complaints(&mut self) -> Vec<String> {
        self.value("0");
        let complaint = |told: &Value| {
            let parameters = &told["params"];
            let url = parameters["request"]["url"].as_str().unwrap_or_default();
            match told["method"].as_str()? {
                "Runtime.exceptionThrown" | "Log.entryAdded" => Some(parameters.to_string()),
                "Runtime.consoleAPICalled" if parameters["type"] == "error" => Some(parameters.to_string()),
                "Network.requestWillBeSent" if !url.starts_with("data:") && !url.ends_with(".html") => Some(url.into()),
                _ => None,
            }
        };
        self.told.iter().filter_map(complaint).collect()
    }

    /// Presses and releases a key.
    pub fn key(&mut self, key: &str, code: u32) {
        for kind in ["keyDown", "keyUp"] {
            let mut event = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code });
            if key == "Enter" && kind == "keyDown" {
                event["text"] = json!("\r");
            }
            self.call("Input.dispatchKeyEvent", event);
        }
    }

    /// Clicks at a place within the first element that `selector` finds: shares of its width and height.
    pub fn click(&mut self, selector: &str, at: (f64, f64)) {
        let place = self.value(&format!(
            "(() => {{ const it = document.querySelector({}); it.scrollIntoView({{ block: 'center', behavior: \
             'instant' }}); const box = it.getBoundingClientRect(); return [box.x + box.width * {}, box.y + \
             box.height * {}]; }})()",
            json!(selector),
            at.0,
            at.1
        ));
        for kind in ["mousePressed", "mouseReleased"] {
            let event = json!({ "type": kind, "x": place[0], "y": place[1], "button": "left", "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", event);
        }
    }

    /// A picture of the top of the page, as PNG, so high.
    pub fn picture(&mut self, width: u32, height: u32) -> Vec<u8> {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size);
        let answer = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        STANDARD.decode(answer["data"].as_str().unwrap()).unwrap()
    }

    /// How many pages the page has on paper.
    pub fn printed(&mut self) -> usize {
        let paper = json!({ "paperWidth": 8.27, "paperHeight": 11.69, "preferCSSPageSize": true });
        let answer = self.call("Page.printToPDF", paper);
        let pdf = STANDARD.decode(answer["data"].as_str().unwrap()).unwrap();
        let text = String::from_utf8_lossy(&pdf);
        text.matches("/Type /Page").count() - text.matches("/Type /Pages").count()
    }
}

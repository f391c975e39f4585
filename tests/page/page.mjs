// Drives the viewer's page in Chromium on SwiftShader, a WebGPU adapter that needs no graphics hardware.
//   node page.mjs modules ADDRESS                  compiles the WGSL of `modules.json` and prints what the browser refuses
//   node page.mjs shot ADDRESS FILE.png [S] [WxH]  waits S seconds for the page and stores a screenshot
//   node page.mjs sentences SITE                   what the page says where it cannot run, and of what it does not find
//   node page.mjs address SITE                     the address follows the page, and the page the address
//   node page.mjs drop SITE                        files that are dropped are opened
import { chromium } from "playwright-core";

const [task, address, file, seconds = "30", size = "1280x720"] = process.argv.slice(2);
const flags = ["--headless=new", "--no-sandbox", "--enable-unsafe-webgpu", "--disable-gpu-watchdog", "--enable-features=Vulkan",
  "--use-vulkan=swiftshader", "--use-webgpu-adapter=swiftshader", "--use-angle=swiftshader",
  "--host-resolver-rules=MAP insecure.test 127.0.0.1"];
const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
const browser = await chromium.launch({ executablePath, args: flags, ignoreDefaultArgs: ["--disable-gpu"] });
const [width, height] = size.split("x").map(Number);
const faults = [];
const pause = ms => new Promise(done => setTimeout(done, ms));

async function opened(address, prepare = async () => {}) {
  const page = await browser.newPage({ viewport: { width, height } });
  page.on("pageerror", error => faults.push(String(error)));
  page.on("console", message => {
    const isMissing = message.text().includes("404");
    if (["error", "warning"].includes(message.type()) && !isMissing) faults.push(message.text());
  });
  await prepare(page);
  await page.goto(address);
  return page;
}

const text = (page, id) => page.evaluate(id => document.getElementById(id).textContent, id);

// A page that compiles shaders on a processor answers late.
const running = page =>
  page.waitForFunction(() => document.getElementById("said").textContent === "", null, { timeout: 240000 });

// Waits until the viewer has shown what was done last: with what follows in the same frame, it would be one step.
const shown = page => page.evaluate(async () => {
  for (let frame = 0; frame < 4; frame++) await new Promise(requestAnimationFrame);
});

async function click(page, x, y) {
  await page.mouse.move(x, y);
  await shown(page);
  await page.mouse.click(x, y);
  await shown(page);
}

// Waits until `found` returns something that `wanted` accepts.
async function expect(what, found, wanted) {
  let last;
  for (let tries = 0; tries < 240; tries++) {
    last = await found();
    if (wanted(last)) return;
    await pause(500);
  }
  faults.push(`${what}: ${last}`);
}

async function modules() {
  const page = await opened(address);
  const refused = await page.evaluate(async () => {
    const modules = await (await fetch("modules.json")).json();
    const device = await (await navigator.gpu.requestAdapter()).requestDevice();
    const found = {};
    for (const text of modules) {
      device.pushErrorScope("validation");
      const { messages } = await device.createShaderModule({ code: text }).getCompilationInfo();
      await device.popErrorScope();
      for (const { type, message, lineNum } of messages.filter(({ type }) => type === "error")) {
        const key = `${type}: ${message}: ${text.split("\n")[lineNum - 1]?.trim()}`;
        found[key] = (found[key] ?? 0) + 1;
      }
    }
    return { count: modules.length, found };
  });
  console.log(`${refused.count} modules`);
  for (const [what, count] of Object.entries(refused.found)) faults.push(`${count} modules: ${what}`);
}

async function shot() {
  const page = await opened(address);
  await running(page);
  await pause(1000 * Number(seconds));
  await page.screenshot({ path: file, timeout: 240000 });
}

async function sentences() {
  const cases = [
    ["insecure", address.replace("localhost", "insecure.test"), undefined, "without encryption"],
    ["no WebGPU", address, page => page.addInitScript(() => delete Navigator.prototype.gpu), "needs WebGPU"],
    ["no adapter", address, page => page.addInitScript(() => { GPU.prototype.requestAdapter = async () => null; }),
      "finds no graphics adapter"],
    ["no program", address, page => page.route("**/*.wasm.gz*", route => route.fulfill({ status: 503 })), "status 503"],
  ];
  for (const [what, address, prepare, wanted] of cases) {
    const page = await opened(address, prepare);
    await expect(what, () => text(page, "said"), said => said.includes(wanted) && !said.includes("JsValue"));
    await page.close();
  }
  faults.splice(0, faults.length, ...faults.filter(fault => !fault.includes("503")));
  const page = await opened(`${address}/#pipeline=tsushma&still`);
  await running(page);
  await expect("a pipeline that is not there", () => text(page, "note"), note => note.includes("did you mean `tsushima`"));
  await page.evaluate(() => { location.hash = "#image=nothing.exr&still"; });
  await expect("an image that is not there", () => text(page, "note"), note => note.includes("no file `nothing.exr`"));
}

async function follows() {
  const page = await opened(`${address}/#pipeline=lynx&image=scene.exr&still&theme=dark`);
  await running(page);
  await expect("the title", () => page.title(), title => title.startsWith("lynx.ron"));
  const hash = () => page.evaluate(() => location.hash);
  // T opens the text; its first line is typed into.
  await click(page, 640, 300);
  await page.keyboard.press("t");
  await shown(page);
  await click(page, 300, 560);
  await page.keyboard.press("Control+Home");
  await page.keyboard.type("// changed\n");
  const isKept = hash => ["image=scene.exr", "still", "theme=dark"].every(part => hash.includes(part));
  await expect("a text that is edited", hash, hash => hash.includes("text=//%20changed") && isKept(hash));
  // A slider: the search leaves one row, somewhere below the facts.
  await click(page, 90, 42);
  await page.keyboard.type("lit.strength");
  await shown(page);
  const before = await hash();
  for (let y = 60; y < 420 && await hash() === before; y += 12) {
    await page.mouse.move(150, y);
    await page.mouse.down();
    await shown(page);
    await page.mouse.move(200, y, { steps: 4 });
    await page.mouse.up();
    await shown(page);
  }
  await expect("a slider that is moved", hash, hash => hash !== before && hash.includes("strength") && isKept(hash));
  await page.evaluate(() => { location.hash = "#pipeline=caracal&image=scene.exr&still"; });
  await expect("an address that is changed", () => page.title(), title => title.startsWith("caracal.ron"));
  await expect("the changed address", hash, hash => hash === "#pipeline=caracal&image=scene.exr&still");
}

// Drops a file of the site on the page, and moves the pointer there, as browsers do after a drop.
async function drop(page, file, x, y) {
  const data = await page.evaluateHandle(async file => {
    const data = new DataTransfer();
    data.items.add(new File([await (await fetch(file)).blob()], file));
    return data;
  }, file);
  await page.dispatchEvent("#viewer", "drop", { dataTransfer: data });
  await page.mouse.move(x, y);
  await shown(page);
}

async function drops() {
  // Without `still`, which changes the pipeline: another one would be asked about.
  const page = await opened(`${address}/#pipeline=cookbook`);
  await running(page);
  await expect("the title", () => page.title(), title => title.startsWith("cookbook.ron"));
  await click(page, 640, 300);
  // On the row of an input that the title does not name, then on the picture.
  await drop(page, "scene.exr", 150, 189);
  await expect("the image that the title names", () => page.title(), title => title.includes("still.exr"));
  await drop(page, "camera.json", 640, 300);
  await drop(page, "broken.json", 640, 300);
  await expect("a camera that is none", () => text(page, "note"), note => note.includes("`broken.json` is no camera"));
  await drop(page, "photo.exr", 640, 300);
  await expect("a photo that is dropped", () => page.title(), title => title.includes("photo.exr 320x180"));
  await drop(page, "dropped.ron", 640, 300);
  await expect("a pipeline that is dropped", () => page.title(), title => title.startsWith("dropped.ron"));
}

await { modules, shot, sentences, address: follows, drop: drops }[task]();
await browser.close();
for (const fault of faults) console.error(fault);
process.exit(faults.length > 0 ? 1 : 0);

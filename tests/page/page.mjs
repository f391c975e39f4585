// Drives the viewer's page in Chromium on SwiftShader, a WebGPU adapter that needs no graphics hardware.
//   node page.mjs modules ADDRESS            compiles the WGSL of `modules.json` and prints what the browser refuses
//   node page.mjs shot ADDRESS FILE.png [S]  waits S seconds for the page and stores a screenshot
import { chromium } from "playwright-core";

const [task, address, file, seconds = "30"] = process.argv.slice(2);
const flags = ["--headless=new", "--no-sandbox", "--enable-unsafe-webgpu", "--disable-gpu-watchdog", "--enable-features=Vulkan",
  "--use-vulkan=swiftshader", "--use-webgpu-adapter=swiftshader", "--use-angle=swiftshader"];
const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
const browser = await chromium.launch({ executablePath, args: flags, ignoreDefaultArgs: ["--disable-gpu"] });
const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
const faults = [];
page.on("pageerror", error => faults.push(String(error)));
page.on("console", message => {
  const isIcon = message.text().includes("404");
  if (["error", "warning"].includes(message.type()) && !isIcon) faults.push(message.text());
});
await page.goto(address);

if (task === "modules") {
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
} else {
  // A page that compiles shaders on a processor answers late.
  await page.waitForFunction(() => document.getElementById("said").textContent === "", null, { timeout: 240000 });
  await new Promise(done => setTimeout(done, 1000 * Number(seconds)));
  await page.screenshot({ path: file, timeout: 240000 });
}
await browser.close();
for (const fault of faults) console.error(fault);
process.exit(faults.length > 0 ? 1 : 0);

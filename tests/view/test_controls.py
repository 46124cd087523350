"""The page's controls in a browser: keys, links, views of the parts, narrow windows."""

import pytest
from support.blob import VIEWS
from support.chromium import Session

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("browser")]

PRESS = """
const canvas = document.querySelector("#canvas");
canvas.focus();
const before = r3gwApp.stage.camera.position.toArray();
canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "w", bubbles: true }));
const moved = () => r3gwApp.stage.camera.position.toArray().some((x, i) => x !== before[i]);
for (let wait = 0; wait < 100 && !moved(); wait += 1) {
  await new Promise((resolve) => setTimeout(resolve, 100));
}
canvas.dispatchEvent(new KeyboardEvent("keyup", { key: "w", bubbles: true }));
return [before, r3gwApp.stage.camera.position.toArray(), document.activeElement.id];
"""
DOME = """
r3gwApp.change({ light: "sun", elevation: 40, azimuth: 10 });
const dome = document.querySelector("#dome");
dome.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowUp", bubbles: true }));
const { elevation, azimuth } = r3gwApp.state;
const ahead = r3gwApp.stage.camera.matrixWorld.elements;
const turn = document.querySelector("#dome-look").getAttribute("transform").match(/[-.\\d]+/)[0];
const looks = Math.atan2(-ahead[8], -ahead[10]) * 180 / Math.PI;
if (Math.abs(Number(turn) - looks) > 1) throw new Error(`${turn} is not ${looks}`);
return [elevation, azimuth, dome.getAttribute("aria-valuetext"), dome.closest("[hidden]")];
"""
LINK = """
r3gwApp.change({ light: "sun", elevation: 33, tone: "filmic", photo: "v_2" });
await new Promise((resolve) => setTimeout(resolve, 900));
const kept = location.hash;
r3gwApp.change({ light: "learned", elevation: 1, tone: "standard" });
location.hash = "#elevation=12&tone=reinhard&light=sun&blend=7&photo=nobody&camera=a,b&x=%";
await new Promise((resolve) => setTimeout(resolve, 300));
const { elevation, tone, light, blend, photo } = r3gwApp.state;
return [kept, { elevation, tone, light, blend, photo }];
"""
LABELS = """
const unnamed = [...document.querySelectorAll("input, select, button, canvas, svg[tabindex]")]
  .filter((each) => !each.labels?.length && !each.getAttribute("aria-label")
    && !each.textContent.trim());
return unnamed.map((each) => each.outerHTML);
"""
MAP = """
const input = document.querySelector("#map-file");
const files = new DataTransfer();
files.items.add(new File(["no picture"], "notes.hdr"));
input.files = files.files;
input.dispatchEvent(new Event("change"));
const message = document.querySelector("#message");
while (!/cannot/.test(message.textContent)) await new Promise((done) => setTimeout(done, 20));
return [message.textContent, r3gwApp.state.light];
"""
ALPHA = """
const url = await r3gwApp.probe({ parts: "PARTS", sky: "SKY" }, "v_0", 64, 48);
const image = await createImageBitmap(await (await fetch(url)).blob());
const context = new OffscreenCanvas(64, 48).getContext("2d");
context.drawImage(image, 0, 0);
const data = context.getImageData(0, 0, 64, 48).data;
return data.filter((_, i) => i % 4 === 3).reduce((sum, value) => sum + value, 0) / (64 * 48 * 255);
"""


def alpha(parts: str, sky: str) -> str:
    """Job that returns the mean opacity of a picture."""
    return ALPHA.replace("PARTS", parts).replace("SKY", sky)


def test_controls(html, tmp_path):
    session = Session(html)
    session.jobs = [
        "return [document.documentElement.scrollWidth, innerWidth];",
        LABELS,
        PRESS,
        DOME,
        LINK,
        MAP,
        alpha("both", "own"),
        alpha("foreground", "own"),
        alpha("both", "none"),
        "return document.querySelector('#coverage').textContent;",
        "return [...document.querySelectorAll('#cameras button')].map((b) => b.title);",
    ]
    width, unnamed, pressed, dome, link, refusal, *rest = session.run(tmp_path, (390, 844))
    covered, foreground, skyless, sentence, cameras = rest
    assert width[0] <= max(width[1], 500)  # Chromium's windows are no narrower than 500 px
    assert unnamed == []
    before, after, focused = pressed
    assert focused == "canvas"
    assert before != after
    assert dome == [43, 10, "43° high, azimuth 10°", None]
    kept, state = link
    assert {"light=sun", "elevation=33", "tone=filmic", "photo=v_2"} <= set(kept[1:].split("&"))
    assert state == {
        "elevation": 12,
        "tone": "reinhard",
        "light": "sun",
        "blend": 0,
        "photo": "v_0",
    }
    assert refusal[0].startswith("notes.hdr cannot be read as a picture")
    assert refusal[1] == "sun"
    assert covered == pytest.approx(1.0, abs=1e-3)
    assert foreground == pytest.approx(skyless, abs=1e-3)
    assert 0.05 < foreground < 0.95
    assert "by 2 photos from within 30°" in sentence
    assert cameras == list(VIEWS)
    assert session.complaints == []

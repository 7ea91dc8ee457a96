#!/usr/bin/env python3
"""Drives the page of `kagero view` in headless Chromium: drag, walk, slider, formula, layer, pixel, save.

Usage: drive_page.py KAGERO SCENES OUT

Each step checks what the page shows, and writes a screenshot to the folder OUT. The browser is controlled through the
DevTools protocol over pipes. The script exits with status 77 if there is no Chromium.
"""

import base64
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import urllib.request


class Browser:
    """A headless Chromium with one page."""

    def __init__(self, program, profile):
        to_child, self.output = os.pipe()
        self.input, from_child = os.pipe()

        def connect():
            first, second = os.dup(to_child), os.dup(from_child)  # numbers above 4
            os.dup2(first, 3)
            os.dup2(second, 4)

        while min(to_child, from_child) < 5:
            to_child, from_child = os.dup(to_child), os.dup(from_child)
        self.process = subprocess.Popen(
            [program, '--headless=new', '--no-sandbox', '--disable-gpu', '--remote-debugging-pipe',
             f'--user-data-dir={profile}', '--no-first-run', 'about:blank'],
            preexec_fn=connect, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.buffer = b''
        self.number = 0
        self.errors = []
        self.session = None
        targets = self.call('Target.getTargets')['targetInfos']
        page = next(t['targetId'] for t in targets if t['type'] == 'page')
        self.session = self.call('Target.attachToTarget', targetId=page, flatten=True)['sessionId']
        for domain in ('Page', 'Runtime', 'Log'):
            self.call(domain + '.enable')

    def read(self):
        while b'\0' not in self.buffer:
            data = os.read(self.input, 1 << 16)
            if not data:
                raise RuntimeError('the browser has ended')
            self.buffer += data
        message, self.buffer = self.buffer.split(b'\0', 1)
        return json.loads(message)

    def call(self, method, **parameters):
        self.number += 1
        message = {'id': self.number, 'method': method, 'params': parameters}
        if self.session:
            message['sessionId'] = self.session
        os.write(self.output, json.dumps(message).encode() + b'\0')
        while True:
            answer = self.read()
            if 'method' in answer:
                self.receive(answer['method'], answer['params'])
            if answer.get('id') == self.number:
                if 'error' in answer:
                    raise RuntimeError(f'{method}: {answer["error"]}')
                return answer['result']

    def receive(self, event, parameters):
        """Records errors that the page reports."""
        if event == 'Runtime.exceptionThrown':
            details = parameters['exceptionDetails']
            self.errors.append(details.get('exception', {}).get('description', details['text']))
        if event == 'Runtime.consoleAPICalled' and parameters['type'] in ('error', 'assert'):
            self.errors.append(f'console: {parameters["args"]}')
        if event == 'Log.entryAdded' and parameters['entry']['level'] == 'error':
            # The browser reports the answers that refuse an invalid value as errors of the network.
            if parameters['entry']['source'] != 'network':
                self.errors.append(parameters['entry']['text'])

    def run(self, script):
        result = self.call('Runtime.evaluate', expression=script, awaitPromise=True, returnByValue=True)
        if 'exceptionDetails' in result:
            raise RuntimeError(f'{script}: {result["exceptionDetails"]}')
        return result['result'].get('value')

    def wait(self, condition, seconds=30):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.run(condition):
                return
            time.sleep(0.05)
        raise AssertionError(f'not within {seconds} s: {condition}; corner: {self.text("corner")}; '
                             f'error: {self.text("error")}')

    def text(self, name):
        return self.run(f'document.getElementById("{name}").textContent')

    def size(self, width, height):
        self.call('Emulation.setDeviceMetricsOverride', width=width, height=height, deviceScaleFactor=1, mobile=False)

    def mouse(self, kind, x, y, **more):
        self.call('Input.dispatchMouseEvent', type=kind, x=x, y=y, **more)

    def drag(self, start, end, steps=10):
        self.mouse('mousePressed', *start, button='left', buttons=1, clickCount=1)
        for i in range(1, steps + 1):
            self.mouse('mouseMoved', *(a + (b - a) * i / steps for a, b in zip(start, end)), button='left', buttons=1)
            time.sleep(0.02)
        self.mouse('mouseReleased', *end, button='left', clickCount=1)

    def key(self, key, seconds=0.0, modifiers=0):
        self.call('Input.dispatchKeyEvent', type='keyDown', key=key, modifiers=modifiers)
        time.sleep(seconds)
        self.call('Input.dispatchKeyEvent', type='keyUp', key=key, modifiers=modifiers)

    def screenshot(self, path):
        path.write_bytes(base64.b64decode(self.call('Page.captureScreenshot')['data']))

    def close(self):
        self.process.terminate()
        self.process.wait()


def find_chromium():
    program = shutil.which('chromium') or shutil.which('chromium-browser') or shutil.which('google-chrome')
    if not program:
        print('There is no Chromium; the package chromium contains it.')
    return program


class Viewer:
    """A running `kagero view` of a scene."""

    def __init__(self, kagero, scene, *options):
        self.process = subprocess.Popen([kagero, 'view', scene, '--port', '0', '--quiet', *options],
                                        stdout=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()

    def stats(self):
        with urllib.request.urlopen(self.url.replace('/?', '/stats?')) as answer:
            return json.load(answer)

    def memory(self):
        status = pathlib.Path(f'/proc/{self.process.pid}/status').read_text()
        return int(next(line.split()[1] for line in status.splitlines() if line.startswith('VmRSS'))) / 1024

    def close(self):
        self.process.send_signal(2)
        assert self.process.wait(20) == 0, 'the viewer must end with status 0 after Ctrl-C'


STILL = 'document.getElementById("corner").textContent.includes("still")'
FINE = 'document.getElementById("corner").textContent.includes("16 rays/pixel")'
PIXELS = ('(() => {const c = document.getElementById("picture"); '
          'const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data; '
          'let h = 0; for (let i = 0; i < d.length; i += 97) h = (h * 31 + d[i]) | 0; return h;})()')


def is_still(browser):
    browser.wait(STILL)


def set_input(browser, name, text):
    browser.run(f'(() => {{const box = document.getElementById({json.dumps(name)}); box.focus(); '
                f'box.value = {json.dumps(text)}; box.dispatchEvent(new Event("input", {{bubbles: true}}));}})()')


def expect(condition, message):
    if not condition:
        raise AssertionError(message)


def drive_sky(browser, viewer, out):
    start = time.monotonic()
    browser.call('Page.navigate', url=viewer.url)
    browser.wait('document.getElementById("corner")?.textContent.includes("×")')
    print(f'first picture after {time.monotonic() - start:.2f} s')
    is_still(browser)
    browser.screenshot(out / 'sky-still.png')
    before = browser.run(PIXELS)
    for i in range(4):
        browser.drag((300 + 20 * i, 300), (420 + 20 * i, 330), 30)
        if i == 3:
            browser.screenshot(out / 'sky-moving.png')
    stats = viewer.stats()
    print('turning:', json.dumps(stats))
    expect(stats['fps'] > 0 and stats['traced_share'] < 0.5, 'a turning view must use the map of directions')
    is_still(browser)
    expect(browser.run(PIXELS) != before, 'dragging must change the picture')
    browser.run('document.getElementById("picture").focus()')
    position = browser.run('document.querySelector("[aria-label=\'position x\']").value')
    browser.key('w', 0.5)
    is_still(browser)
    expect(browser.run('document.querySelector("[aria-label=\'position x\']").value') != position, 'W must walk')
    state = browser.run('location.hash')
    expect('camera.position' in state, f'the URL must keep the state: {state}')
    browser.mouse('mouseWheel', 300, 300, deltaX=0, deltaY=-300)
    browser.wait('document.getElementById("control-camera-fov").value < 127')
    browser.wait('location.hash.includes("camera.fov")')
    browser.run('window.is_old = true; location.reload()')
    browser.wait('!window.is_old && document.getElementById("corner")?.textContent.includes("×")')
    expect(browser.run('document.getElementById("control-camera-fov").value') != '127',
           'the URL must restore the state')
    browser.wait(FINE, 60)
    browser.screenshot(out / 'sky-fine.png')


def drive_parameters(browser, viewer, out):
    browser.call('Page.navigate', url=viewer.url)
    browser.wait('document.getElementById("corner")?.textContent.includes("×")')
    is_still(browser)
    before = browser.run(PIXELS)
    for i in range(20):
        set_input(browser, 'control-space-rg', str(0.08 + 0.002 * i))
        time.sleep(0.1)
    print('room, dragging rg:', json.dumps(viewer.stats()))
    is_still(browser)
    expect(browser.run(PIXELS) != before, 'the parameter must change the picture')
    set_input(browser, 'control-space-rg', '-1')
    browser.wait('!document.getElementById("error").hidden')
    expect('rg' in browser.text('error'), browser.text('error'))
    browser.screenshot(out / 'room-out-of-range.png')
    set_input(browser, 'control-space-rg', '0.12')
    browser.wait('document.getElementById("error").hidden')
    browser.run('(() => {const s = document.getElementById("choice-layer"); s.value = "steps"; '
                's.dispatchEvent(new Event("change"));})()')
    browser.wait('!document.getElementById("legend").hidden')
    is_still(browser)
    browser.screenshot(out / 'room-layer.png')
    browser.mouse('mousePressed', 300, 300, button='left', clickCount=1)
    browser.mouse('mouseReleased', 300, 300, button='left', clickCount=1)
    browser.wait('document.getElementById("pixel").textContent.includes("hit: room")')
    browser.run('document.getElementById("ray").scrollIntoView()')
    time.sleep(0.3)
    browser.screenshot(out / 'room-pixel.png')
    browser.size(400, 800)
    time.sleep(0.5)
    expect(browser.run('document.documentElement.scrollWidth') <= 400, 'the page must fit into 400 pixels')
    browser.screenshot(out / 'room-narrow.png')
    browser.run('window.scrollTo(0, 500)')
    time.sleep(0.3)
    browser.screenshot(out / 'room-narrow-controls.png')
    browser.size(1280, 800)


def drive_formula(browser, viewer, out):
    browser.call('Page.navigate', url=viewer.url)
    browser.wait('document.getElementById("corner")?.textContent.includes("×")')
    is_still(browser)
    before = browser.run(PIXELS)
    set_input(browser, 'control-space-let-n', '0.85 - 0.3*z^3 + 0.03*cso(3*pi*x)')
    browser.wait('!document.getElementById("error").hidden')
    expect('cso' in browser.text('error'), browser.text('error'))
    browser.screenshot(out / 'formula-mistake.png')
    set_input(browser, 'control-space-let-n', '0.85 - 0.2*z^3 + 0.03*cos(3*pi*x)')
    browser.wait('document.getElementById("error").hidden')
    is_still(browser)
    expect(browser.run(PIXELS) != before, 'the formula must change the picture')
    browser.screenshot(out / 'formula-changed.png')


def drive_saving(browser, viewer, out):
    downloads = out / 'downloads'
    downloads.mkdir(exist_ok=True)
    session, browser.session = browser.session, None
    browser.call('Browser.setDownloadBehavior', behavior='allow', downloadPath=str(downloads.resolve()))
    browser.session = session
    for name, start in (('toml', b'[space]'), ('png', b'\x89PNG'), ('exr', b'v/1\x01')):
        file = downloads / f'kagero.{name}'
        file.unlink(missing_ok=True)
        browser.run(f'document.querySelector("[data-format={name}]").click()')
        end = time.monotonic() + 30
        while not file.exists() and time.monotonic() < end:
            browser.run('0')
            time.sleep(0.1)
        expect(file.exists() and file.read_bytes().startswith(start), f'saving as {name} must write a file')


def main():
    kagero, scenes, out = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    program = find_chromium()
    if not program:
        return 77
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(program, profile)
        try:
            browser.size(1280, 800)
            for drive, scene, options in ((drive_sky, 'galaxy', ['--size', '1280x720']), (drive_parameters, 'room', []),
                                          (drive_formula, 'formula-mirage', ['--size', '480x320'])):
                viewer = Viewer(kagero, str(scenes / f'{scene}.toml'), *options)
                try:
                    drive(browser, viewer, out)
                    if drive is drive_parameters:
                        drive_saving(browser, viewer, out)
                finally:
                    viewer.close()
        finally:
            browser.close()
    expect(not browser.errors, f'errors in the page: {browser.errors}')
    return 0


if __name__ == '__main__':
    sys.exit(main())

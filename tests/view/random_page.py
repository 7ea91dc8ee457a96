#!/usr/bin/env python3
"""Drives the page of `kagero view` in headless Chromium with random input.

Usage: random_page.py KAGERO SCENE OUT [--seconds S] [--seed N] [--size WxH]

The input consists of drags, keys, wheel, clicks, sliders, numbers, edits of formulas, choices of layers and observers,
resizes, downloads and reloads. The script checks that the page reports no error, that no request fails, that the memory
of the viewer and of the page does not grow after the first third of the time, and that the viewer still answers. It
writes the measured memory as memory.csv, and screenshots at widths of 1280 and 400 pixels, to the folder OUT. It exits
with status 77 if there is no Chromium.
"""

import argparse
import json
import pathlib
import random
import sys
import tempfile
import time

from drive_page import Browser, Viewer, expect, find_chromium

# Answers of the viewer that are no failures: a picture, none because newer input has interrupted it, and the refusal of
# an invalid value.
EXPECTED_STATUS = (200, 204, 422)
KEYS = ['w', 'a', 's', 'd', 'q', 'e', '+', '-', 'ArrowUp', 'ArrowDown', 'ArrowLeft', 'ArrowRight']
CHARACTERS = '0123456789.+-*/^()xyzrp eE'


class WatchedBrowser(Browser):
    """A browser that also records failed requests and measures the memory of the page."""

    def __init__(self, program, profile):
        super().__init__(program, profile)
        self.addresses = {}
        self.answers = 0
        self.call('Network.enable')

    def receive(self, event, parameters):
        super().receive(event, parameters)
        if event == 'Network.requestWillBeSent':
            self.addresses[parameters['requestId']] = parameters['request']['url'].split('token=')[0]
        if event == 'Network.responseReceived':
            response = parameters['response']
            self.answers += 1
            if response['url'].startswith('http') and response['status'] not in EXPECTED_STATUS:
                self.errors.append(f'status {response["status"]} of {self.addresses.get(parameters["requestId"])}')
        if event == 'Network.loadingFailed' and not parameters.get('canceled'):
            address = self.addresses.get(parameters['requestId'], '')
            if parameters['errorText'] != 'net::ERR_ABORTED':
                self.errors.append(f'{address}: {parameters["errorText"]}')
        if event in ('Network.loadingFinished', 'Network.loadingFailed'):
            self.addresses.pop(parameters['requestId'], None)

    def memory(self):
        """Returns the size of the heap of JavaScript in MB, and the number of nodes of the document."""
        self.call('HeapProfiler.collectGarbage')
        heap = self.call('Runtime.getHeapUsage')['usedSize'] / 2**20
        return heap, self.call('Memory.getDOMCounters')['nodes']

    def open(self, url):
        self.call('Page.navigate', url=url)
        self.wait('document.getElementById("corner")?.textContent.includes("×")')


class Input:
    """Random input. Each public method is one kind."""

    def __init__(self, browser, seed):
        self.browser, self.random = browser, random.Random(seed)

    def point(self):
        return self.random.randint(5, 800), self.random.randint(5, 600)

    def drag(self):
        self.browser.drag(self.point(), self.point(), self.random.randint(2, 15))

    def keys(self):
        self.browser.run('document.getElementById("picture").focus()')
        for _ in range(self.random.randint(1, 4)):
            self.browser.key(self.random.choice(KEYS), 0.2 * self.random.random(), self.random.choice((0, 0, 8)))

    def wheel(self):
        x, y = self.point()
        self.browser.mouse('mouseWheel', x, y, deltaX=0, deltaY=self.random.randint(-300, 300))

    def click(self):
        x, y = self.point()
        self.browser.mouse('mousePressed', x, y, button='left', clickCount=1)
        self.browser.mouse('mouseReleased', x, y, button='left', clickCount=1)

    def hover(self):
        self.browser.mouse('mouseMoved', *self.point())
        time.sleep(0.4 * self.random.random())

    def change(self, selector, new_value, event='input'):
        """Changes a random control. `new_value` is an expression for its value, in terms of `box` and `u`."""
        u = [self.random.random() for _ in range(4)]
        self.browser.run(
            f'(() => {{const boxes = [...document.querySelectorAll({json.dumps(selector)})], u = {json.dumps(u)}; '
            'if (boxes.length === 0) return; const box = boxes[Math.floor(u[0] * boxes.length)]; box.focus(); '
            f'box.value = {new_value}; box.dispatchEvent(new Event("{event}", {{bubbles: true}}));}})()')

    def slider(self):
        for _ in range(self.random.randint(1, 8)):
            self.change('#panel input[type=range]', '+box.min + u[1] * (box.max - box.min)')
            time.sleep(0.05)

    def number(self):
        self.change('#panel input[type=number]', '["", String(100 * (u[1] - 0.5)), String(+box.value * (1 + 0.2 * '
                    '(u[2] - 0.5))), "-1e9"][Math.floor(4 * u[3])]')

    def formula(self):
        """Inserts or removes a character of a formula, or restores all formulas."""
        character = json.dumps(self.random.choice(CHARACTERS))
        self.change('#panel textarea',
                    '((i) => u[2] < 0.3 ? box.defaultText ?? box.value : (box.defaultText ??= box.value, '
                    'u[2] < 0.6 ? box.value.slice(0, i) + box.value.slice(i + 1) : '
                    f'box.value.slice(0, i) + {character} + box.value.slice(i)))(Math.floor(u[1] * box.value.length))')

    def choice(self):
        self.change('#panel select', 'box.options[Math.floor(u[1] * box.options.length)].value', 'change')

    def pixel(self):
        self.change('#pixel-x, #pixel-y', 'Math.floor(2000 * u[1])')
        self.browser.run('document.getElementById("pixel-show").click()')

    def reset(self):
        self.browser.run('document.getElementById("reset").click()')

    def resize(self):
        self.browser.size(self.random.choice((320, 400, 800, 1280, self.random.randint(320, 1600))),
                          self.random.randint(400, 1000))

    def save(self):
        name = self.random.choice(('toml', 'png', 'exr'))
        self.browser.run(f'document.querySelector("[data-format={name}]").click()')

    def reload(self):
        """Loads the page again. It keeps the state, whose values may be invalid."""
        self.browser.run('window.is_old = true')
        self.browser.call('Page.reload')
        end = time.monotonic() + 60
        while time.monotonic() < end:
            try:
                if self.browser.run('!window.is_old && (document.getElementById("corner")?.textContent.includes("×") '
                                    '|| document.getElementById("error")?.hidden === false)'):
                    return
            except RuntimeError:  # the old document ends while it evaluates the expression
                pass
            time.sleep(0.05)
        raise AssertionError('the page does not load again within 60 s')

    def pause(self):
        time.sleep(2 * self.random.random())

    def any(self):
        common = [self.drag, self.keys, self.wheel, self.click, self.hover, self.slider, self.number, self.formula,
                  self.choice, self.pixel, self.pause]
        rare = [self.reset, self.resize, self.save]
        kind = self.random.random()
        self.random.choice(common if kind < 0.85 else rare if kind < 0.99 else [self.reload])()


def measure(browser, viewer, seconds, seed, rows):
    """Appends tuples to `rows`: time, memory of the viewer, heap of the page, nodes of the page."""
    inputs, start = Input(browser, seed), time.monotonic()
    while (now := time.monotonic() - start) < seconds:
        inputs.any()
        if now >= len(rows) * min(5, seconds / 60):
            rows.append((now, viewer.memory(), *browser.memory()))
            print('{:4.0f} s: viewer {:.0f} MB, page {:.1f} MB and {:.0f} nodes'.format(*rows[-1]), flush=True)
        expect(not browser.errors, f'after {now:.0f} s with seed {seed}: {browser.errors}')


def check_growth(rows, column, name, unit, allowance):
    """Compares the last third of the time with the second third. The first third is for warming up."""
    values = [row[column] for row in rows]
    third = len(values) // 3
    middle, last = max(values[third:2 * third]), max(values[2 * third:])
    print(f'{name}: at most {middle:.1f} {unit} in the second third of the time, {last:.1f} in the last')
    expect(last <= 1.1 * middle + allowance, f'{name} grows from {middle:.1f} to {last:.1f} {unit}')


def finish(browser, viewer, out):
    """Checks that the page still shows a picture after all input, and writes screenshots."""
    browser.run('document.getElementById("reset").click()')
    browser.wait('document.getElementById("corner").textContent.includes("still")', 120)
    expect(viewer.stats()['width'] > 0, 'the viewer must still answer')
    for width in (1280, 400):
        browser.size(width, 800)
        time.sleep(1)
        browser.screenshot(out / f'random-{width}.png')
    browser.call('Page.navigate', url='about:blank')
    expect(not browser.errors, str(browser.errors))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('kagero')
    parser.add_argument('scene')
    parser.add_argument('out', type=pathlib.Path)
    parser.add_argument('--seconds', type=float, default=600)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--size', default='480x320')
    arguments = parser.parse_args()
    program, out = find_chromium(), arguments.out
    if not program:
        return 77
    out.mkdir(parents=True, exist_ok=True)
    rows = []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = WatchedBrowser(program, profile)
        viewer = Viewer(arguments.kagero, arguments.scene, '--size', arguments.size)
        try:
            session, browser.session = browser.session, None
            browser.call('Browser.setDownloadBehavior', behavior='allow', downloadPath=profile)
            browser.session = session
            browser.size(1280, 800)
            browser.open(viewer.url)
            measure(browser, viewer, arguments.seconds, arguments.seed, rows)
            finish(browser, viewer, out)
        finally:
            browser.close()
            viewer.close()
            (out / 'memory.csv').write_text('seconds,viewer_mb,page_mb,nodes\n' +
                                            ''.join(','.join(f'{x:.4g}' for x in row) + '\n' for row in rows))
    check_growth(rows, 1, 'memory of the viewer', 'MB', 16)
    check_growth(rows, 2, 'heap of the page', 'MB', 2)
    check_growth(rows, 3, 'size of the document', 'nodes', 500)
    print(f'{browser.answers} answers, no error')
    return 0


if __name__ == '__main__':
    sys.exit(main())

"""The reference sketch, compiled for this computer with stand-ins for its few library calls."""

from __future__ import annotations

from pathlib import Path
import shutil
import subprocess

import pytest

from bpc_perception.core.extruder.tic import parse_line, TicState

SKETCH = Path(__file__).resolve().parents[3] / 'firmware/extruder_bridge/extruder_bridge.ino'

# The calls of Arduino's core and of Pololu's library, as its Tic.h declares them.
HEADERS = {
    'Arduino.h': r'''
#pragma once
#include <cstdint>
#include <cstdio>
static unsigned long now_ms = 4294967290UL;
inline unsigned long millis() { return now_ms; }
struct SerialPort {
  void begin(unsigned long) {}
  void print(const char *text) { fputs(text, stdout); }
  void println(const char *text) { print(text); print("\r\n"); }
};
static SerialPort Serial;
''',
    'Wire.h': r'''
#pragma once
struct Bus { void begin() {} };
static Bus Wire;
''',
    'Tic.h': r'''
#pragma once
#include "Arduino.h"
enum class TicStepMode : uint8_t { Microstep8 = 3 };
enum class TicOperationState : uint8_t { Normal = 10 };
static uint8_t last_error = 0;
static uint32_t occurred = 1UL << 20;
struct TicI2C {
  TicI2C(uint8_t) {}
  int32_t getCurrentPosition() { return -2147483647; }
  int32_t getCurrentVelocity() { return 2000000; }
  TicStepMode getStepMode() { return TicStepMode::Microstep8; }
  TicOperationState getOperationState() { return TicOperationState::Normal; }
  bool getEnergized() { return true; }
  bool getPositionUncertain() { return true; }
  uint16_t getErrorStatus() { return 64; }
  uint32_t getErrorsOccurred() { uint32_t bits = occurred; occurred = 0; return bits; }
  uint16_t getVinVoltage() { return 9120; }
  uint8_t getLastError() { return last_error; }
};
''',
}
MAIN = r'''
#include "Arduino.h"
#include "sketch.ino"
int main() {
  setup();
  report();          // all bits of errors that occurred so far
  now_ms = 20;
  report();          // they are kept, though reading cleared them
  last_error = 1;
  report();          // nothing
}
'''


@pytest.mark.skipif(not shutil.which('c++'), reason='no C++ compiler, which ./bpc asks for')
def test_the_sketch_speaks_the_protocol(tmp_path: Path) -> None:
    for name, text in {**HEADERS, 'main.cpp': MAIN, 'sketch.ino': SKETCH.read_text()}.items():
        (tmp_path / name).write_text(text)
    subprocess.run(['c++', '-std=c++17', '-Wall', '-Werror', '-I', tmp_path, '-o',
                    tmp_path / 'sketch', tmp_path / 'main.cpp'], check=True, timeout=60)
    said = subprocess.run([tmp_path / 'sketch'], capture_output=True, check=True, timeout=10)
    first, second, end = said.stdout.split(b'\n')
    assert end == b''
    state = TicState(4294967290 * 10**6, -2147483647, 2000000, 3, 10, 3, 64, 1 << 20, 9120)
    assert parse_line(first) == state
    assert parse_line(second).errors_occurred == 1 << 20
    assert parse_line(second).device_ns == 20 * 10**6

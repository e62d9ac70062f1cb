// Sends the state of a Tic stepper driver to the computer, a line a state; see ../README.md.
// The Tic hangs on I2C, since an Uno's only serial line goes to the computer.

#include <Tic.h>
#include <Wire.h>

const unsigned long BAUD = 115200;
const unsigned long PERIOD_MS = 20;
const uint8_t TIC_ADDRESS = 14;

TicI2C tic(TIC_ADDRESS);
uint32_t errorsOccurred = 0;
unsigned long lastReport = 0;

// CRC-16/XMODEM, bit by bit: the same on every board.
uint16_t crc16(const char *text) {
  uint16_t crc = 0;
  for (; *text; text++) {
    crc ^= (uint16_t)(uint8_t)*text << 8;
    for (uint8_t bit = 0; bit < 8; bit++) {
      crc = crc & 0x8000 ? (crc << 1) ^ 0x1021 : crc << 1;
    }
  }
  return crc;
}

// What the Tic answered, and whether it has answered every time so far.
bool answered = true;
template <typename Value>
Value checked(Value value) {
  answered = answered && tic.getLastError() == 0;
  return value;
}

void report() {
  answered = true;
  const unsigned long now = millis();
  const int32_t position = checked(tic.getCurrentPosition());
  const int32_t velocity = checked(tic.getCurrentVelocity());
  const uint8_t stepMode = (uint8_t)checked(tic.getStepMode());
  const uint8_t operationState = (uint8_t)checked(tic.getOperationState());
  const uint8_t miscFlags =
      (checked(tic.getEnergized()) ? 1 : 0) | (checked(tic.getPositionUncertain()) ? 2 : 0);
  const uint16_t errorStatus = checked(tic.getErrorStatus());
  // This clears the bits in the Tic, so they are kept here.
  errorsOccurred |= checked(tic.getErrorsOccurred());
  const uint16_t vin = checked(tic.getVinVoltage());
  if (!answered) {
    return;  // rather nothing than a state that is none
  }
  char line[112];
  snprintf(line, sizeof(line), "BPC1,%lu,%ld,%ld,%u,%u,%u,%u,%lu,%u", now, (long)position,
           (long)velocity, stepMode, operationState, miscFlags, errorStatus,
           (unsigned long)errorsOccurred, vin);
  char ending[8];
  snprintf(ending, sizeof(ending), "*%04X", crc16(line));
  Serial.print(line);
  Serial.println(ending);
}

void setup() {
  Wire.begin();
  Serial.begin(BAUD);
}

void loop() {
  if (millis() - lastReport >= PERIOD_MS) {
    lastReport += PERIOD_MS;
    report();
  }
}

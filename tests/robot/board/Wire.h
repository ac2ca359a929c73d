// An INA260 at address 0x40: 11.1 V, 0.5 A, 5.55 W in its own units.
#pragma once
#include <cstdint>

#include "Arduino.h"

struct TwoWire {
  void begin() { begun = true; }
  void beginTransmission(int address) {
    if (!begun || address != 0x40) broken("wrong I2C use");
  }
  void write(int value) { pointer = value; }
  int endTransmission(bool) { return 0; }
  int requestFrom(int, int) {
    spend(150);
    next = 0;
    return 2;
  }
  int read() {
    const uint16_t value = pointer == 1 ? 400 : pointer == 2 ? 8880 : 555;
    return next++ == 0 ? value >> 8 : value & 0xFF;
  }
  bool begun = false;
  int pointer = 0;
  int next = 0;
};
extern TwoWire Wire;

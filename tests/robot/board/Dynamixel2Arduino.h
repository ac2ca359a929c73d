// The parts of Dynamixel2Arduino that the sketch uses, with the servos' rules checked at every call.
#pragma once
#include <cstdint>

#include "Arduino.h"

namespace ControlTableItem {
enum Item {
  DRIVE_MODE, OPERATING_MODE, HOMING_OFFSET, VELOCITY_LIMIT, MAX_POSITION_LIMIT, MIN_POSITION_LIMIT,
  TORQUE_ENABLE, HARDWARE_ERROR_STATUS, BUS_WATCHDOG, PROFILE_ACCELERATION, PROFILE_VELOCITY, GOAL_POSITION,
  PRESENT_POSITION, PRESENT_INPUT_VOLTAGE, ITEMS
};
}

namespace DYNAMIXEL {
struct InfoSyncBulkBuffer_t { uint8_t *p_buf; uint16_t buf_capacity; bool is_completed; };
struct XELInfoSyncWrite_t { uint8_t *p_data; uint8_t id; } __attribute__((packed));
struct InfoSyncWriteInst_t {
  uint16_t addr;
  uint16_t addr_length;
  XELInfoSyncWrite_t *p_xels;
  uint8_t xel_count;
  bool is_info_changed;
  InfoSyncBulkBuffer_t packet;
} __attribute__((packed));
}

class Dynamixel2Arduino {
 public:
  Dynamixel2Arduino(HardwareSerial &, int) {}
  void begin(unsigned long baud);
  bool setPortProtocolVersion(float version);
  bool ping(uint8_t id);
  uint16_t getModelNumber(uint8_t id);
  bool torqueOn(uint8_t id);
  bool torqueOff(uint8_t id);
  int32_t readControlTableItem(uint8_t item, uint8_t id, uint32_t timeout = 100);
  bool writeControlTableItem(uint8_t item, uint8_t id, int32_t value, uint32_t timeout = 100);
  bool syncWrite(DYNAMIXEL::InfoSyncWriteInst_t *infos);
};

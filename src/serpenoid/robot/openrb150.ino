// @TITLE@
// Plays a gait on an OpenRB-150 with Dynamixel2Arduino, without a computer. Written by `serpenoid export`.
//
// Press the button (pin @BUTTON_PIN@ to GND): the robot approaches the first row slowly, plays, and switches torque off.
// Press it again at any time: torque off at once. A fast blinking LED reports a fault; press reset after curing it.

#include <Arduino.h>
#include <Dynamixel2Arduino.h>
#include <Wire.h>

const uint8_t JOINTS = @JOINTS@;
const uint16_t STEPS = @STEPS@;
const uint16_t ROWS = @ROWS@;
const uint16_t END_ROW = @END_ROW@;  // commanded and held after each cycle: the first row, or the end of a transient
const uint16_t CYCLES = @CYCLES@;
const uint32_t CYCLE_US = @CYCLE_US@UL;
const uint32_t PAUSE_US = @PAUSE_US@UL;
const uint32_t BAUD = @BAUD@UL;
const uint8_t BUTTON_PIN = @BUTTON_PIN@;
const bool STREAM_POWER = @STREAM_POWER@;  // INA260 at I2C address 0x40: t_s,voltage_V,current_A,power_W over USB

const uint16_t MODEL[JOINTS] = {@MODELS@};  // @MODEL_NAMES@
const int32_t MINIMUM_DECIVOLT = @MINIMUM_DECIVOLT@;
const int32_t MAXIMUM_DECIVOLT = @MAXIMUM_DECIVOLT@;
const int32_t ARRIVAL_TICKS[JOINTS] = {@ARRIVAL_TICKS@};
const int32_t APPROACH_LIMIT_TICKS[JOINTS] = {@APPROACH_LIMIT_TICKS@};
const int32_t APPROACH_VELOCITY[JOINTS] = {@APPROACH_VELOCITIES@};  // @VELOCITY_UNIT@
const bool WIDEN_LIMITS = @WIDEN_LIMITS@;
const int16_t FACTORY_SPEED_LIMIT[JOINTS] = {@FACTORY_SPEED_LIMITS@};  // @VELOCITY_UNIT@
const int32_t POSITION_MODE[JOINTS] = {@POSITION_MODES@};
const int32_t WATCHDOG[JOINTS] = {@WATCHDOGS@};  // 20 ms
const uint32_t APPROACH_MS = @APPROACH_MS@UL;
const uint32_t LOOK_US = 50000UL;  // button and servos are looked at this often in long rows and pauses
const uint32_t LOOK_TIME_US = @LOOK_TIME_US@UL;  // and one look takes at most about this long

const uint8_t ID[JOINTS] = {@IDS@};
const int16_t MINIMUM[JOINTS] = {@MINIMA@};
const int16_t MAXIMUM[JOINTS] = {@MAXIMA@};
const int16_t SPEED_LIMIT[JOINTS] = {@SPEED_LIMITS@};  // @VELOCITY_UNIT@
const int16_t PLAY_VELOCITY[JOINTS] = {@PLAY_VELOCITIES@};

// Goal positions in ticks: one row per step, joint_1 (tail) first. `const` keeps the table in flash.
const int16_t TABLE[ROWS][JOINTS] = {
@TABLE@
};

// An OpenRB-150 switches the direction of its bus by itself: no direction pin.
Dynamixel2Arduino dxl(Serial1, -1);
using namespace ControlTableItem;

int32_t goals[JOINTS];
DYNAMIXEL::XELInfoSyncWrite_t goalOf[JOINTS];
DYNAMIXEL::InfoSyncWriteInst_t goalPacket;
uint8_t off = 0;
DYNAMIXEL::XELInfoSyncWrite_t offOf[JOINTS];
DYNAMIXEL::InfoSyncWriteInst_t offPacket;
uint16_t present = 0;
uint8_t nextLook = 0;
uint32_t streamStart = 0;
uint32_t nextSample = 0;

void prepare(DYNAMIXEL::InfoSyncWriteInst_t &packet, DYNAMIXEL::XELInfoSyncWrite_t *parts, uint16_t item, uint16_t size) {
  packet.packet.p_buf = nullptr;
  packet.packet.is_completed = false;
  packet.addr = item;
  packet.addr_length = size;
  packet.p_xels = parts;
  packet.xel_count = JOINTS;
  packet.is_info_changed = true;
}

// All at once, so that a servo that does not answer keeps no other waiting; then one by one, which asks for an answer.
void torqueOffAll() {
  for (uint8_t attempt = 0; attempt < 2; attempt++) {
    offPacket.is_info_changed = true;
    dxl.syncWrite(&offPacket);
  }
  for (uint8_t j = 0; j < JOINTS; j++) {
    dxl.torqueOff(ID[j]);
  }
  digitalWrite(LED_BUILTIN, LOW);
}

// Torque off, say why, and blink for good.
void fail(const char *reason, uint8_t id) {
  torqueOffAll();
  Serial.print("# fault: ");
  Serial.print(reason);
  Serial.print(", servo ");
  Serial.println(id);
  for (;;) {
    digitalWrite(LED_BUILTIN, HIGH);
    delay(100);
    digitalWrite(LED_BUILTIN, LOW);
    delay(100);
  }
}

bool pressed() {
  return digitalRead(BUTTON_PIN) == LOW;
}

// A whole press: down for 30 ms, then released.
void waitForPress() {
  for (;;) {
    if (pressed()) {
      delay(30);
      if (pressed()) {
        while (pressed()) {
          delay(1);
        }
        return;
      }
    }
    delay(1);
  }
}

void set(uint8_t item, uint8_t id, int32_t value) {
  if (dxl.readControlTableItem(item, id) != value && !dxl.writeControlTableItem(item, id, value)) {
    fail("setting refused", id);
  }
}

// Somebody set the servo's own memory to less than the robot file allows: not to be undone without a word.
bool hasNarrowerLimits(uint8_t j) {
  return dxl.readControlTableItem(MIN_POSITION_LIMIT, ID[j]) > MINIMUM[j] ||
         dxl.readControlTableItem(MAX_POSITION_LIMIT, ID[j]) < MAXIMUM[j] ||
         dxl.readControlTableItem(VELOCITY_LIMIT, ID[j]) <
             (SPEED_LIMIT[j] < FACTORY_SPEED_LIMIT[j] ? SPEED_LIMIT[j] : FACTORY_SPEED_LIMIT[j]);
}

void setUpServo(uint8_t j) {
  const uint8_t id = ID[j];
  if (!dxl.ping(id) || dxl.getModelNumber(id) != MODEL[j]) {
    fail("no servo of the robot file's model answers", id);
  }
  dxl.torqueOff(id);
  set(BUS_WATCHDOG, id, 0);
  set(DRIVE_MODE, id, 0);
  set(OPERATING_MODE, id, POSITION_MODE[j]);
  set(HOMING_OFFSET, id, 0);
  if (!WIDEN_LIMITS && hasNarrowerLimits(j)) {
    fail("its own limits are narrower than the robot file's (export --widen-limits overwrites them)", id);
  }
  set(VELOCITY_LIMIT, id, SPEED_LIMIT[j]);
  set(MIN_POSITION_LIMIT, id, MINIMUM[j]);
  set(MAX_POSITION_LIMIT, id, MAXIMUM[j]);
}

void checkServo(uint8_t j) {
  const uint8_t id = ID[j];
  if (dxl.readControlTableItem(HARDWARE_ERROR_STATUS, id) != 0) {
    fail("hardware error", id);
  }
  const int32_t decivolt = dxl.readControlTableItem(PRESENT_INPUT_VOLTAGE, id);
  if (decivolt < MINIMUM_DECIVOLT || decivolt > MAXIMUM_DECIVOLT) {
    fail("voltage", id);
  }
}

void setVelocity(uint8_t j, int32_t velocity) {
  set(PROFILE_ACCELERATION, ID[j], 0);
  set(PROFILE_VELOCITY, ID[j], velocity);
}

void sendRow(uint16_t step) {
  present = step;
  for (uint8_t j = 0; j < JOINTS; j++) {
    goals[j] = TABLE[step][j];
  }
  goalPacket.is_info_changed = true;
  dxl.syncWrite(&goalPacket);
}

int32_t distance(uint8_t j) {
  const int32_t position = dxl.readControlTableItem(PRESENT_POSITION, ID[j]);
  return abs(position - (int32_t)TABLE[0][j]);
}

// Slowly to the first row. False: the button was pressed.
bool approach() {
  for (uint8_t j = 0; j < JOINTS; j++) {
    checkServo(j);
    const int32_t position = dxl.readControlTableItem(PRESENT_POSITION, ID[j]);
    if (position < MINIMUM[j] || position > MAXIMUM[j] || distance(j) > APPROACH_LIMIT_TICKS[j]) {
      fail("too far from the first row", ID[j]);
    }
  }
  for (uint8_t j = 0; j < JOINTS; j++) {
    setVelocity(j, APPROACH_VELOCITY[j]);
    dxl.writeControlTableItem(BUS_WATCHDOG, ID[j], WATCHDOG[j]);  // it waits for torque
  }
  for (uint8_t j = 0; j < JOINTS; j++) {
    dxl.writeControlTableItem(GOAL_POSITION, ID[j], dxl.readControlTableItem(PRESENT_POSITION, ID[j]));
    dxl.torqueOn(ID[j]);
  }
  sendRow(0);
  const uint32_t begin = millis();
  for (uint8_t j = 0; j < JOINTS; ) {
    if (pressed()) {
      return false;
    }
    sendRow(0);  // every servo must hear something, or its watchdog stops it
    if (distance(j) <= ARRIVAL_TICKS[j]) {
      j++;
    } else if (millis() - begin > APPROACH_MS) {
      fail("did not arrive at the first row", ID[j]);
    }
  }
  for (uint8_t j = 0; j < JOINTS; j++) {
    setVelocity(j, PLAY_VELOCITY[j]);
  }
  return true;
}

int16_t readSensor(uint8_t address) {
  Wire.beginTransmission(0x40);
  Wire.write(address);
  Wire.endTransmission(false);
  Wire.requestFrom(0x40, 2);
  const uint16_t high = (uint16_t)Wire.read() & 0xFF;
  return (int16_t)(high << 8 | ((uint16_t)Wire.read() & 0xFF));
}

// INA260: 1.25 mA, 1.25 mV and 10 mW per bit; at most every 10 ms.
void streamPower() {
  if (!STREAM_POWER || (int32_t)(micros() - nextSample) < 0) {
    return;
  }
  nextSample = micros() + 10000UL;
  Serial.print((micros() - streamStart) / 1e6, 4);
  Serial.print(',');
  Serial.print((uint16_t)readSensor(2) * 0.00125, 4);
  Serial.print(',');
  Serial.print(readSensor(1) * 0.00125, 5);
  Serial.print(',');
  Serial.println((uint16_t)readSensor(3) * 0.01, 3);
}

// Until `due` after `start` [us, both may wrap around]; false: the button was pressed.
bool waitUntil(uint32_t start, uint32_t due) {
  uint32_t lastLook = micros() - LOOK_US;
  while (micros() - start < due) {
    const uint32_t now = micros();
    const uint32_t remaining = due - (now - start);
    if (remaining > due) {
      break;  // the deadline passed between two looks at the clock
    }
    if (pressed()) {
      return false;
    }
    if (remaining > LOOK_TIME_US && now - lastLook >= LOOK_US) {
      lastLook = now;
      checkServo(nextLook);
      sendRow(present);
      nextLook = (nextLook + 1) % JOINTS;
      streamPower();
    } else if (remaining > LOOK_TIME_US / 4) {
      streamPower();
    }
  }
  return true;
}

// Row i of a cycle is due i CYCLE_US / STEPS after the cycle's start. False: the button was pressed.
bool playCycle(uint32_t start) {
  for (uint16_t i = 0; i < STEPS; i++) {
    sendRow(i);
    if (!waitUntil(start, (uint32_t)((uint64_t)(i + 1) * CYCLE_US / STEPS))) {
      return false;
    }
  }
  return true;
}

void play() {
  uint32_t start = micros();
  streamStart = nextSample = start;
  for (uint16_t n = 0; n < CYCLES; n++) {
    if (!playCycle(start)) {
      return;
    }
    if (PAUSE_US > 0 || n + 1 == CYCLES) {
      sendRow(END_ROW);
    }
    if (!waitUntil(start, CYCLE_US + PAUSE_US)) {
      return;
    }
    start += CYCLE_US + PAUSE_US;
  }
}

void setup() {
  Serial.begin(115200);
  pinMode(LED_BUILTIN, OUTPUT);
  pinMode(BUTTON_PIN, INPUT_PULLUP);
  if (STREAM_POWER) {
    Wire.begin();
  }
  dxl.begin(BAUD);
  dxl.setPortProtocolVersion(2.0);
  for (uint8_t j = 0; j < JOINTS; j++) {
    goalOf[j].id = ID[j];
    goalOf[j].p_data = (uint8_t *)&goals[j];
    offOf[j].id = ID[j];
    offOf[j].p_data = &off;
  }
  prepare(goalPacket, goalOf, @GOAL_ADDRESS@, @GOAL_SIZE@);
  prepare(offPacket, offOf, @TORQUE_ADDRESS@, @TORQUE_SIZE@);
  torqueOffAll();
}

void loop() {
  waitForPress();
  for (uint8_t j = 0; j < JOINTS; j++) {
    setUpServo(j);
  }
  digitalWrite(LED_BUILTIN, HIGH);
  if (approach()) {
    play();
  }
  torqueOffAll();
  while (pressed()) {
    delay(1);
  }
  delay(200);
}

// Runs a sketch on the host. Arguments: seconds to run, then what happens: press@S  error@S  sag@S  gone@S  wrap  narrow@S
// The servos' model: MODEL_NUMBER, FACTORY_VELOCITY [0.229 rpm] and DECIVOLT as macros.
// Prints one line per event; exits with 3 if the sketch breaks a rule of the servos or of the schedule's watchdog.
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "Arduino.h"
#include "Dynamixel2Arduino.h"
#include "Wire.h"

using namespace ControlTableItem;

void setup();
void loop();

HardwareSerial Serial, Serial1;
TwoWire Wire;

static uint64_t now_us = 0, clock_offset = 0, end_us = 0;
static unsigned long baud = 0;
static std::vector<uint64_t> presses;
static uint64_t error_us = ~0ull, sag_us = ~0ull, gone_us = ~0ull;
static bool narrow = false;  // somebody set servo 4 to less than the robot file allows

struct Servo {
  int32_t item[ITEMS] = {};
  double position = 2048;
  uint64_t heard_us = 0;
};
static std::map<int, Servo> servos;

void broken(const std::string &rule) {
  printf("broken %s\n", rule.c_str());
  exit(3);
}

static void move(Servo &servo, uint64_t us) {
  if (!servo.item[TORQUE_ENABLE]) return;
  const double units = servo.item[PROFILE_VELOCITY] ? servo.item[PROFILE_VELOCITY] : FACTORY_VELOCITY;
  const double way = units * 0.229 * 4096 / 60 * us * 1e-6, left = servo.item[GOAL_POSITION] - servo.position;
  servo.position += std::fabs(left) < way ? left : std::copysign(way, left);
  if (servo.item[BUS_WATCHDOG] > 0 && now_us - servo.heard_us > servo.item[BUS_WATCHDOG] * 20000ull)
    broken("watchdog starved");
}

void spend(uint64_t us) {
  now_us += us;
  if (now_us >= gone_us && servos.count(4)) servos[4].item[TORQUE_ENABLE] = 0;  // unplugged: no bus, no power
  for (auto &entry : servos) move(entry.second, us);
  if (now_us > end_us) throw Finished();
}

uint32_t micros() { spend(1); return (uint32_t)(now_us + clock_offset); }
uint32_t millis() { spend(1); return (uint32_t)((now_us + clock_offset) / 1000); }
void delay(uint32_t ms) { spend(1000ull * ms); }
void pinMode(int, int) {}
void digitalWrite(int pin, int level) { if (pin == LED_BUILTIN) printf("led %llu %d\n", (unsigned long long)now_us, level); }
int digitalRead(int) {
  spend(1);
  for (uint64_t press : presses) if (now_us >= press && now_us < press + 80000) return LOW;
  return HIGH;
}

void HardwareSerial::print(const char *text) { spend(20); printf("%s", text); }
void HardwareSerial::print(char letter) { spend(5); printf("%c", letter); }
void HardwareSerial::print(int number) { spend(20); printf("%d", number); }
void HardwareSerial::print(double number, int digits) { spend(60); printf("%.*f", digits, number); }
void HardwareSerial::println(int number) { print(number); printf("\n"); }
void HardwareSerial::println(double number, int digits) { print(number, digits); printf("\n"); }

static Servo *talk(int id, int bytes) {
  if (!baud) broken("bus used before begin");
  spend((uint64_t)(bytes * 10 * 1e6 / baud) + 100);
  if (!servos.count(id)) broken("unknown servo");
  if (now_us >= gone_us && id == 4) { spend(100000); return nullptr; }
  servos[id].heard_us = now_us;
  return &servos[id];
}

void Dynamixel2Arduino::begin(unsigned long rate) {
  baud = rate;
  for (int id = 1; id <= JOINT_COUNT; id++) {
    servos[id].item[OPERATING_MODE] = 1;
    servos[id].item[MAX_POSITION_LIMIT] = narrow && id == 4 ? 2400 : 4095;
    servos[id].item[VELOCITY_LIMIT] = FACTORY_VELOCITY;
  }
}
bool Dynamixel2Arduino::setPortProtocolVersion(float version) { return version == 2.0f; }
bool Dynamixel2Arduino::ping(uint8_t id) { return talk(id, 24) != nullptr; }
uint16_t Dynamixel2Arduino::getModelNumber(uint8_t id) { return talk(id, 27) ? MODEL_NUMBER : 0; }
bool Dynamixel2Arduino::torqueOn(uint8_t id) { return writeControlTableItem(TORQUE_ENABLE, id, 1); }
bool Dynamixel2Arduino::torqueOff(uint8_t id) { return writeControlTableItem(TORQUE_ENABLE, id, 0); }

int32_t Dynamixel2Arduino::readControlTableItem(uint8_t item, uint8_t id, uint32_t) {
  if (item >= ITEMS) broken("unknown item");
  Servo *servo = talk(id, 29);
  if (!servo) return 0;
  if (item == PRESENT_POSITION) return (int32_t)std::lround(servo->position);
  if (item == PRESENT_INPUT_VOLTAGE) return now_us >= sag_us ? DECIVOLT * 4 / 5 : DECIVOLT;
  if (item == HARDWARE_ERROR_STATUS) return now_us >= error_us && id == 4 ? 4 : 0;
  return servo->item[item];
}

static void check_goal(const Servo &servo, int32_t goal) {
  if (goal < servo.item[MIN_POSITION_LIMIT] || goal > servo.item[MAX_POSITION_LIMIT]) broken("goal outside limits");
}

bool Dynamixel2Arduino::writeControlTableItem(uint8_t item, uint8_t id, int32_t value, uint32_t) {
  if (item >= ITEMS) broken("unknown item");
  Servo *servo = talk(id, 28);
  if (!servo) return false;
  if (item < TORQUE_ENABLE && servo->item[TORQUE_ENABLE]) broken("EEPROM written with torque on");
  if (item == GOAL_POSITION) check_goal(*servo, value);
  if (item == TORQUE_ENABLE && value) {
    if (servo->item[OPERATING_MODE] != 3) broken("torque on in another mode");
    if (servo->item[BUS_WATCHDOG] == 0) broken("torque on without a watchdog");
    if (servo->item[PROFILE_VELOCITY] == 0) broken("torque on at full speed");
    if (std::abs(servo->item[GOAL_POSITION] - servo->position) > 2) broken("torque on with a jump");
  }
  servo->item[item] = value;
  if (item == TORQUE_ENABLE) printf("torque %llu %d %d\n", (unsigned long long)now_us, id, value);
  if (item == PROFILE_VELOCITY) printf("velocity %llu %d %d\n", (unsigned long long)now_us, id, value);
  return true;
}

static bool switch_off(DYNAMIXEL::InfoSyncWriteInst_t &infos) {
  for (int j = 0; j < infos.xel_count; j++) {
    if (*infos.p_xels[j].p_data != 0) broken("torque on by sync write");
    servos[infos.p_xels[j].id].item[TORQUE_ENABLE] = 0;
    printf("torque %llu %d 0\n", (unsigned long long)now_us, infos.p_xels[j].id);
  }
  spend((uint64_t)((14 + 2 * infos.xel_count) * 10 * 1e6 / baud) + 100);
  return true;
}

bool Dynamixel2Arduino::syncWrite(DYNAMIXEL::InfoSyncWriteInst_t *infos) {
  if (infos->addr == 64 && infos->addr_length == 1) return switch_off(*infos);
  if (infos->addr != 116 || infos->addr_length != 4 || infos->xel_count != JOINT_COUNT) broken("wrong sync write");
  if (!infos->is_info_changed) broken("stale sync write");
  printf("row %llu", (unsigned long long)now_us);
  for (int j = 0; j < infos->xel_count; j++) {
    int32_t goal;
    memcpy(&goal, infos->p_xels[j].p_data, 4);
    Servo &servo = servos[infos->p_xels[j].id];
    check_goal(servo, goal);
    servo.item[GOAL_POSITION] = goal;
    printf(" %d", goal);
  }
  printf("\n");
  spend((uint64_t)((14 + 5 * infos->xel_count) * 10 * 1e6 / baud) + 100);
  for (auto &entry : servos) entry.second.heard_us = now_us;
  return true;
}

int main(int count, char **words) {
  end_us = (uint64_t)(atof(words[1]) * 1e6);
  for (int k = 2; k < count; k++) {
    const std::string word = words[k];
    const uint64_t at = (uint64_t)(atof(word.substr(word.find('@') + 1).c_str()) * 1e6);
    if (word.rfind("press@", 0) == 0) presses.push_back(at);
    if (word.rfind("error@", 0) == 0) error_us = at;
    if (word.rfind("sag@", 0) == 0) sag_us = at;
    if (word.rfind("gone@", 0) == 0) gone_us = at;
    if (word.rfind("narrow@", 0) == 0) narrow = true;
    if (word == "wrap") clock_offset = 0xFFFFFFFFull - 3000000;  // the clock wraps around while playing
  }
  try {
    setup();
    for (;;) loop();
  } catch (Finished &) {
  }
  for (auto &entry : servos) printf("final %d %d\n", entry.first, entry.second.item[TORQUE_ENABLE]);
  return 0;
}

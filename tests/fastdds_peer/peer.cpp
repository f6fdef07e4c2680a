// A participant by another vendor's DDS, led by lines on its standard input:
//
//   read TOPIC TYPE reliable|best_effort volatile|transient_local bytes|lengths
//   write TOPIC TYPE reliable|best_effort volatile|transient_local
//   send TOPIC HEX
//
// It tells in lines what happens; times are CLOCK_MONOTONIC [ns]:
//
//   participant GUID USERDATA          writer|reader TOPIC TYPE GUID USERDATA
//   matched TOPIC COUNT                gone GUID
//   data TOPIC TIME HEX|LENGTH         sent TOPIC TIME
//
// It ends at the end of its input. GUIDs and bytes are hexadecimal; no user data is "-".
#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>
#include <string>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>

#include "raw_type.hpp"

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

namespace {

std::mutex telling;

void tell(const std::string& line) {
  const std::lock_guard<std::mutex> lock(telling);
  std::cout << line << std::endl;
}

long long now_ns() {
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
}

template <class Octets>
std::string hex(const Octets& octets) {
  static const char digits[] = "0123456789abcdef";
  std::string text;
  for (const std::uint8_t octet : octets) {
    text += digits[octet >> 4];
    text += digits[octet & 15];
  }
  return text.empty() ? "-" : text;
}

std::string hex(const rtps::GUID_t& guid) {
  Bytes octets(guid.guidPrefix.value, guid.guidPrefix.value + 12);
  octets.insert(octets.end(), guid.entityId.value, guid.entityId.value + 4);
  return hex(octets);
}

Bytes from_hex(const std::string& text) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16)));
  return bytes;
}

class Discovered : public fast::DomainParticipantListener {
  void on_participant_discovery(fast::DomainParticipant*,
                                rtps::ParticipantDiscoveryInfo&& found) override {
    if (found.status == rtps::ParticipantDiscoveryInfo::DISCOVERED_PARTICIPANT)
      tell("participant " + hex(found.info.m_guid) + " " + hex(found.info.m_userData));
    if (found.status == rtps::ParticipantDiscoveryInfo::DROPPED_PARTICIPANT ||
        found.status == rtps::ParticipantDiscoveryInfo::REMOVED_PARTICIPANT)
      tell("gone " + hex(found.info.m_guid));
  }

  void on_publisher_discovery(fast::DomainParticipant*, rtps::WriterDiscoveryInfo&& found) override {
    if (found.status == rtps::WriterDiscoveryInfo::DISCOVERED_WRITER) told("writer", found.info);
  }

  void on_subscriber_discovery(fast::DomainParticipant*,
                               rtps::ReaderDiscoveryInfo&& found) override {
    if (found.status == rtps::ReaderDiscoveryInfo::DISCOVERED_READER) told("reader", found.info);
  }

  template <class Endpoint>
  void told(const std::string& kind, const Endpoint& endpoint) {
    tell(kind + " " + endpoint.topicName().to_string() + " " + endpoint.typeName().to_string() +
         " " + hex(endpoint.guid()) + " " + hex(endpoint.m_qos.m_userData));
  }
};

class Heard : public fast::DataReaderListener {
 public:
  Heard(std::string topic, bool whole) : topic_(std::move(topic)), whole_(whole) {}

  void on_data_available(fast::DataReader* reader) override {
    Bytes bytes;
    fast::SampleInfo info;
    while (reader->take_next_sample(&bytes, &info) == ReturnCode_t::RETCODE_OK) {
      const auto time = std::to_string(now_ns());
      const auto content = whole_ ? hex(bytes) : std::to_string(bytes.size());
      if (info.valid_data) tell("data " + topic_ + " " + time + " " + content);
    }
  }

  void on_subscription_matched(fast::DataReader*,
                               const fast::SubscriptionMatchedStatus& status) override {
    tell("matched " + topic_ + " " + std::to_string(status.current_count));
  }

 private:
  std::string topic_;
  bool whole_;
};

class Told : public fast::DataWriterListener {
 public:
  explicit Told(std::string topic) : topic_(std::move(topic)) {}

  void on_publication_matched(fast::DataWriter*,
                              const fast::PublicationMatchedStatus& status) override {
    tell("matched " + topic_ + " " + std::to_string(status.current_count));
  }

 private:
  std::string topic_;
};

template <class Qos>
void set_quality(Qos& qos, const std::string& reliability, const std::string& durability) {
  qos.reliability().kind = reliability == "reliable" ? fast::RELIABLE_RELIABILITY_QOS
                                                     : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = durability == "transient_local" ? fast::TRANSIENT_LOCAL_DURABILITY_QOS
                                                          : fast::VOLATILE_DURABILITY_QOS;
  qos.history().depth = 10;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
}

class Peer {
 public:
  explicit Peer(std::uint32_t domain) {
    const auto mask = fast::StatusMask::none();
    participant_ = fast::DomainParticipantFactory::get_instance()->create_participant(
        domain, fast::PARTICIPANT_QOS_DEFAULT, &discovered_, mask);
    if (participant_ == nullptr) throw std::runtime_error("no participant");
    publisher_ = participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  }

  ~Peer() {
    participant_->delete_contained_entities();
    fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  void obey(const std::string& line) {
    std::istringstream words(line);
    std::string verb, topic;
    words >> verb >> topic;
    if (verb == "send") {
      std::string text;
      words >> text;
      auto bytes = from_hex(text);
      const auto time = now_ns();
      if (!writers_.at(topic)->write(&bytes)) throw std::runtime_error("not written: " + topic);
      tell("sent " + topic + " " + std::to_string(time));
      return;
    }
    std::string type, reliability, durability, content;
    words >> type >> reliability >> durability >> content;
    if (verb == "read") read(topic, type, reliability, durability, content == "bytes");
    if (verb == "write") write(topic, type, reliability, durability);
  }

 private:
  fast::Topic* topic(const std::string& name, const std::string& type) {
    fast::TypeSupport support(new RawType(type));
    support.register_type(participant_);
    auto* known = dynamic_cast<fast::Topic*>(participant_->lookup_topicdescription(name));
    auto* found =
        known ? known : participant_->create_topic(name, type, fast::TOPIC_QOS_DEFAULT);
    if (found == nullptr) throw std::runtime_error("no topic " + name);
    return found;
  }

  void read(const std::string& name, const std::string& type, const std::string& reliability,
            const std::string& durability, bool whole) {
    auto qos = fast::DATAREADER_QOS_DEFAULT;
    set_quality(qos, reliability, durability);
    heard_.push_back(std::make_unique<Heard>(name, whole));
    auto* reader = subscriber_->create_datareader(topic(name, type), qos, heard_.back().get());
    if (reader == nullptr) throw std::runtime_error("no reader of " + name);
  }

  void write(const std::string& name, const std::string& type, const std::string& reliability,
             const std::string& durability) {
    auto qos = fast::DATAWRITER_QOS_DEFAULT;
    set_quality(qos, reliability, durability);
    told_.push_back(std::make_unique<Told>(name));
    writers_[name] = publisher_->create_datawriter(topic(name, type), qos, told_.back().get());
    if (writers_[name] == nullptr) throw std::runtime_error("no writer of " + name);
  }

  Discovered discovered_;
  std::vector<std::unique_ptr<Heard>> heard_;
  std::vector<std::unique_ptr<Told>> told_;
  std::map<std::string, fast::DataWriter*> writers_;
  fast::DomainParticipant* participant_;
  fast::Publisher* publisher_;
  fast::Subscriber* subscriber_;
};

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::cerr << "usage: peer DOMAIN" << std::endl;
    return 2;
  }
  Peer peer(static_cast<std::uint32_t>(std::stoul(words[1])));
  for (std::string line; std::getline(std::cin, line);) peer.obey(line);
  return 0;
}

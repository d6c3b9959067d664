// As much of rclcpp's interface as the how-to's node uses: this is not ROS. `spin` reads lines from standard input, a topic's
// name and values, hands them to whoever has subscribed, and what is published is printed.
#pragma once

#include <cstdio>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <sensor_msgs/msg/joint_state.hpp>
#include <sstream>
#include <std_msgs/msg/float64_multi_array.hpp>
#include <string>

namespace rclcpp {

struct Topics {
    std::map<std::string, std::function<void(const sensor_msgs::msg::JointState&)>> states;
    std::map<std::string, std::function<void(const std_msgs::msg::Float64MultiArray&)>> commands;
};

inline Topics& topics() {
    static Topics all;
    return all;
}

template <class Message>
class Publisher {
  public:
    using SharedPtr = std::shared_ptr<Publisher>;
    explicit Publisher(std::string topic) : topic_(std::move(topic)) {}
    void publish(const Message& message) {
        std::printf("%s", topic_.c_str());
        for (const double value : message.data) std::printf(" %.17g", value);
        std::printf("\n");
    }

  private:
    std::string topic_;
};

template <class Message>
struct Subscription {
    using SharedPtr = std::shared_ptr<Subscription>;
};

struct Logger {};
struct Clock {};

class Node {
  public:
    explicit Node(const std::string&) {}

    template <class Message>
    typename Publisher<Message>::SharedPtr create_publisher(const std::string& topic, int) {
        return std::make_shared<Publisher<Message>>(topic);
    }

    template <class Message, class Callback>
    typename Subscription<Message>::SharedPtr create_subscription(const std::string& topic, int, Callback callback) {
        if constexpr (std::is_same_v<Message, sensor_msgs::msg::JointState>) topics().states[topic] = callback;
        else topics().commands[topic] = callback;
        return std::make_shared<Subscription<Message>>();
    }

    Logger get_logger() const { return {}; }
    std::shared_ptr<Clock> get_clock() const { return std::make_shared<Clock>(); }
};

inline void init(int, char**) {}
inline void shutdown() {}

template <class AnyNode>
void spin(std::shared_ptr<AnyNode>) {
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream words(line);
        std::string topic, name;
        words >> topic;
        if (topics().states.count(topic)) {
            sensor_msgs::msg::JointState state;
            for (double value; words >> name >> value;) state.name.push_back(name), state.position.push_back(value);
            topics().states.at(topic)(state);
        } else {
            std_msgs::msg::Float64MultiArray command;
            for (double value; words >> value;) command.data.push_back(value);
            topics().commands.at(topic)(command);
        }
    }
}

}  // namespace rclcpp

#define RCLCPP_INFO_THROTTLE(logger, clock, milliseconds, ...) \
    ((void)(logger), (void)(clock), (void)(milliseconds), (void)std::fprintf(stderr, __VA_ARGS__))

"""The node of docs/howto/ros2.md, compiled with stand-ins of ROS's headers: it publishes the model's force."""

import re
import subprocess
from pathlib import Path

import numpy as np

from tests.codegen.package.made import write
from tfra.codegen.c.files import files
from tfra.codegen.config.read import load
from tfra.model.cover.scenes import contact_codes
from tfra.model.tfra import Status

PAGE = Path("docs/howto/ros2.md")

NODE = """
#pragma once
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#define RCLCPP_ERROR(logger, ...) std::printf(__VA_ARGS__)
namespace rclcpp {
struct SensorDataQoS {};
struct Time {};
template <class T> struct Publisher {
    using SharedPtr = std::shared_ptr<Publisher>;
    void publish(const T &m)
    {
        std::printf("%s %.17g %.17g %.17g\\n", m.header.frame_id.c_str(), m.wrench.force.x, m.wrench.force.y,
                    m.wrench.force.z);
    }
};
template <class T> struct Subscription {
    using SharedPtr = std::shared_ptr<Subscription>;
};
inline std::function<void(const void *)> spinning;
struct Node {
    explicit Node(const std::string &) {}
    Time now() { return {}; }
    int get_logger() { return 0; }
    template <class T> typename Publisher<T>::SharedPtr create_publisher(const char *, SensorDataQoS)
    {
        return std::make_shared<Publisher<T>>();
    }
    template <class T, class F>
    typename Subscription<T>::SharedPtr create_subscription(const char *, SensorDataQoS, F f)
    {
        spinning = [f](const void *m) { f(*static_cast<const T *>(m)); };
        return {};
    }
};
inline void init(int, char **) {}
inline void shutdown() {}
void spin(std::shared_ptr<Node>);
}
"""
CODES = """
#pragma once
#include <cstdint>
#include <vector>
namespace std_msgs::msg {
struct Int16MultiArray {
    std::vector<int16_t> data;
};
}
"""
WRENCH = """
#pragma once
#include <rclcpp/rclcpp.hpp>
namespace geometry_msgs::msg {
struct WrenchStamped {
    struct {
        rclcpp::Time stamp;
        std::string frame_id;
    } header;
    struct {
        struct {
            double x, y, z;
        } force;
    } wrench;
};
}
"""
SPIN = """
#include <rclcpp/rclcpp.hpp>
#include <std_msgs/msg/int16_multi_array.hpp>
void rclcpp::spin(std::shared_ptr<Node>)
{
    std_msgs::msg::Int16MultiArray frame;
    int length, code;
    while (std::scanf("%d", &length) == 1) {
        frame.data.clear();
        while (length-- > 0 && std::scanf("%d", &code) == 1)
            frame.data.push_back(int16_t(code));
        spinning(&frame);
    }
}
"""


def test_the_node_publishes_the_models_force(tmp_path: Path) -> None:
    (node,) = re.findall(r"^   ```cpp\n(.*?)^   ```", PAGE.read_text(), re.M | re.S)
    design = load("examples/learned_resultant.toml").design
    headers = {
        "ros/rclcpp/rclcpp.hpp": NODE,
        "ros/std_msgs/msg/int16_multi_array.hpp": CODES,
        "ros/geometry_msgs/msg/wrench_stamped.hpp": WRENCH,
    }
    write(tmp_path, files(design) | headers | {"node.cpp": node, "spin.cpp": SPIN})
    sources = [f"{design.name}.c", f"{design.name}_tables.c"]
    subprocess.run(["gcc", "-std=c99", "-O1", "-c", *sources], cwd=tmp_path, check=True)
    objects = [source.replace(".c", ".o") for source in sources]
    command = ["g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", "-I.", "-Iros", "-o", "node", "node.cpp", "spin.cpp"]
    subprocess.run([*command, *objects], cwd=tmp_path, check=True)

    codes = contact_codes(design, 20, seed=1).reshape(20, -1)
    sent = "".join(f"{len(frame)} {' '.join(map(str, frame))}\n" for frame in codes) + "3 0 0 0\n"
    done = subprocess.run([tmp_path / "node"], input=sent, capture_output=True, text=True, check=True)
    *said, last = done.stdout.splitlines()
    assert last == "a frame of 3 codes"
    forces = np.array([[float(value) for value in line.split()[1:]] for line in said])
    words = design.model(codes).words
    fields = {field.name: words[:, field.start : field.start + field.count] * field.lsb for field in design.layout}
    plausible = (fields["status"][:, 0].astype(int) & Status.IMPLAUSIBLE) == 0
    assert plausible.sum() > 5
    np.testing.assert_allclose(forces, (fields["resultant"] * 2.0 ** -fields["exponent"])[plausible], rtol=1e-12)

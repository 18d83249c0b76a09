"""The definitions of the ROS 1 messages that a lab speaks; `messages` says what they mean.

They are written out, so that a port needs none of ROS's packages of messages, of which Debian has no ardrone_autonomy.
A slip would change a sum (`rosmsg`), and no node would talk to us.

References: github.com/ros/common_msgs (1.13), github.com/ros/std_msgs, github.com/AutonomyLab/ardrone_autonomy (1.4).
"""

from fledge.lab.wire.rosmsg import Kind

HEADER = Kind("std_msgs/Header", "uint32 seq  time stamp  string frame_id")
EMPTY = Kind("std_msgs/Empty", "")
VECTOR = Kind("geometry_msgs/Vector3", "float64 x  float64 y  float64 z")
POINT = Kind("geometry_msgs/Point", "float64 x  float64 y  float64 z")
QUATERNION = Kind("geometry_msgs/Quaternion", "float64 x  float64 y  float64 z  float64 w")
TRANSFORM = Kind(
    "geometry_msgs/Transform",
    "geometry_msgs/Vector3 translation  geometry_msgs/Quaternion rotation",
    (VECTOR, QUATERNION),
)
TRANSFORM_STAMPED = Kind(
    "geometry_msgs/TransformStamped",
    "std_msgs/Header header  string child_frame_id  geometry_msgs/Transform transform",
    (HEADER, TRANSFORM),
)
TWIST = Kind("geometry_msgs/Twist", "geometry_msgs/Vector3 linear  geometry_msgs/Vector3 angular", (VECTOR,))
POSE = Kind(
    "geometry_msgs/Pose",
    "geometry_msgs/Point position  geometry_msgs/Quaternion orientation",
    (POINT, QUATERNION),
)
POSE_COVARIANCE = Kind(
    "geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose  float64[36] covariance", (POSE,)
)
TWIST_COVARIANCE = Kind(
    "geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist  float64[36] covariance", (TWIST,)
)
ODOMETRY = Kind(
    "nav_msgs/Odometry",
    """std_msgs/Header header  string child_frame_id
    geometry_msgs/PoseWithCovariance pose  geometry_msgs/TwistWithCovariance twist""",
    (HEADER, POSE_COVARIANCE, TWIST_COVARIANCE),
)
JOY = Kind("sensor_msgs/Joy", "std_msgs/Header header  float32[] axes  int32[] buttons", (HEADER,))
IMAGE = Kind(
    "sensor_msgs/Image",
    """std_msgs/Header header  uint32 height  uint32 width  string encoding
    uint8 is_bigendian  uint32 step  uint8[] data""",
    (HEADER,),
)
NAVDATA = Kind(
    "ardrone_autonomy/Navdata",
    """std_msgs/Header header  float32 batteryPercent  uint32 state
    int32 magX  int32 magY  int32 magZ  int32 pressure  int32 temp
    float32 wind_speed  float32 wind_angle  float32 wind_comp_angle
    float32 rotX  float32 rotY  float32 rotZ  int32 altd  float32 vx  float32 vy  float32 vz
    float32 ax  float32 ay  float32 az  uint8 motor1  uint8 motor2  uint8 motor3  uint8 motor4
    uint32 tags_count  uint32[] tags_type  uint32[] tags_xc  uint32[] tags_yc
    uint32[] tags_width  uint32[] tags_height  float32[] tags_orientation  float32[] tags_distance
    float32 tm""",
    (HEADER,),
)

# find_package(rankdrop CONFIG REQUIRED), with -Drankdrop_DIR=$(python -m rankdrop.headers --cmake-dir)
#
#   rankdrop::monitor    headers: rankdrop/monitor.hpp (C++17), no library and no Python
#   rankdrop::monitor_c  the functions of rankdrop/monitor.h, compiled once, for C and whatever calls it
if(NOT TARGET rankdrop::monitor)
  get_filename_component(_rankdrop_root "${CMAKE_CURRENT_LIST_DIR}/.." ABSOLUTE)
  add_library(rankdrop::monitor INTERFACE IMPORTED)
  set_target_properties(rankdrop::monitor PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${_rankdrop_root}/include"
    INTERFACE_COMPILE_FEATURES cxx_std_17)
  if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang")
    # a*b + c is not contracted: the same bits as in Python; -Wno-psabi: packs are passed inside inlined functions only
    set_property(TARGET rankdrop::monitor PROPERTY INTERFACE_COMPILE_OPTIONS
      $<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=off> $<$<COMPILE_LANGUAGE:CXX>:-Wno-psabi>)
  endif()
  add_library(rankdrop_monitor_c STATIC EXCLUDE_FROM_ALL "${CMAKE_CURRENT_LIST_DIR}/monitor_c.cpp")
  set_target_properties(rankdrop_monitor_c PROPERTIES POSITION_INDEPENDENT_CODE ON)
  target_link_libraries(rankdrop_monitor_c PUBLIC rankdrop::monitor)
  add_library(rankdrop::monitor_c ALIAS rankdrop_monitor_c)
  unset(_rankdrop_root)
endif()
